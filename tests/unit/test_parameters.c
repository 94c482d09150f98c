#include "tribo/parameters.h"
#include "tribo/status.h"

#include "number/ranges.h"
#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_f32.h"
#include "unity.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct
{
    unsigned    number;
    const char *key;
} numbered_t;

#define REGISTER(group, symbol, member, key, unit, low, high, standard, change, number, condition, sentence)           \
    {(number), TRIBO_KEY_##group key},
static const numbered_t registers[] = {TRIBO_PARAMETERS(REGISTER)};

#define ROWS (sizeof registers / sizeof registers[0])

/// The lists of loop, feed-forward and guard; the drive keeps a set as three blocks of words.
static const unsigned block_first[] = {0x100, 0x200, 0x2e2}, block_end[] = {0x1fe, 0x2e0, 0x300};

static size_t block_of(unsigned number)
{
    size_t block = 0;
    while (block < 3 && (number < block_first[block] || number >= block_end[block]))
    {
        block++;
    }
    TEST_ASSERT_TRUE(block < 3);
    return block;
}

/// tests/golden/registers.txt is what drives in the field have on the bus. A release appends to it, nothing changes it. What is not in
/// it yet stands behind.
static void test_no_released_register_moves(void)
{
    char     line[128];
    unsigned last[3]  = {0};
    bool     is[ROWS] = {false};
    FILE    *file     = fopen(TRIBO_GOLDEN_DIR "/registers.txt", "r");
    TEST_ASSERT_NOT_NULL(file);
    while (fgets(line, sizeof line, file) != NULL)
    {
        char               *key;
        const unsigned long number = strtoul(line, &key, 16);
        size_t              i      = 0;
        key += strspn(key, " ");
        key[strcspn(key, "\n")] = '\0';
        while (i + 1u < ROWS && strcmp(registers[i].key, key) != 0)
        {
            i++;
        }
        TEST_ASSERT_EQUAL_STRING(registers[i].key, key);
        TEST_ASSERT_EQUAL_HEX_MESSAGE(number, registers[i].number, key);
        is[i]                      = true;
        unsigned *const last_of_it = &last[block_of((unsigned)number)];
        *last_of_it                = number > *last_of_it ? (unsigned)number : *last_of_it;
    }
    (void)fclose(file);
    for (size_t i = 0; i < ROWS; i++)
    {
        const unsigned number = registers[i].number;
        TEST_ASSERT_TRUE_MESSAGE(number == 0u || is[i] || number > last[block_of(number)], registers[i].key);
    }
}

static void test_registers_follow_each_other_in_three_blocks(void)
{
    for (size_t block = 0; block < 3; block++)
    {
        unsigned count = 0, last = 0;
        for (size_t i = 0; i < ROWS; i++)
        {
            const unsigned number = registers[i].number;
            if (number >= block_first[block] && number < block_end[block])
            {
                TEST_ASSERT_EQUAL_MESSAGE(0, number % 2u, registers[i].key);
                last = number > last ? number : last;
                count++;
            }
            for (size_t j = 0; j < i; j++)
            {
                TEST_ASSERT_TRUE_MESSAGE(number == 0u || registers[j].number != number, registers[i].key);
            }
        }
        TEST_ASSERT_EQUAL_HEX(block_first[block] + 2u * (count - 1u), last);
    }
}

static void test_every_default_is_in_its_range(void)
{
#define CHECK(group, symbol, member, key, unit, low, high, standard, change, number, condition, sentence)              \
    TEST_ASSERT_TRUE_MESSAGE((standard) >= (low) && (standard) <= (high), key);
    TRIBO_PARAMETERS(CHECK)
#undef CHECK
}

static void test_the_ends_of_a_range_are_in_it_and_a_nan_is_not(void)
{
    tribo_friction_f32_config_t config = tribo_force_loop_f32_paper().compensator.friction;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, PARAMETERS_CHECK(tribo_friction_parameters, &config));
#define ENDS(group, symbol, field, key, unit, low, high, standard, change, number, condition, sentence)                \
    {                                                                                                                  \
        const float good  = config.field;                                                                              \
        const float in[]  = {(float)(low), (float)(high)};                                                             \
        const float out[] = {nextafterf((float)(low), -INFINITY), nextafterf((float)(high), INFINITY), NAN, INFINITY}; \
        for (size_t i = 0; i < 2; i++)                                                                                 \
        {                                                                                                              \
            config.field = in[i];                                                                                      \
            TEST_ASSERT_EQUAL_INT_MESSAGE(TRIBO_OK, PARAMETERS_CHECK(tribo_friction_parameters, &config), key);        \
        }                                                                                                              \
        for (size_t i = 0; i < 4; i++)                                                                                 \
        {                                                                                                              \
            config.field = out[i];                                                                                     \
            TEST_ASSERT_EQUAL_INT_MESSAGE(TRIBO_ERR_##symbol,                                                          \
                                          PARAMETERS_CHECK(tribo_friction_parameters, &config),                        \
                                          key);                                                                        \
        }                                                                                                              \
        config.field = good;                                                                                           \
    }
    TRIBO_FRICTION_PARAMETERS(ENDS)
#undef ENDS
}

static void test_a_whole_number_is_checked_as_one(void)
{
    tribo_friction_f32_config_t config = {.table_length = 32};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, PARAMETERS_CHECK(tribo_table_parameters, &config));
    config.table_length = 33;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_TABLE_LENGTH, PARAMETERS_CHECK(tribo_table_parameters, &config));
}

static void test_the_version_is_the_projects(void)
{
    char numbers[32];
    (void)snprintf(numbers, sizeof numbers, "%d.%d.%d", TRIBO_VERSION_MAJOR, TRIBO_VERSION_MINOR, TRIBO_VERSION_PATCH);
    TEST_ASSERT_EQUAL_STRING(numbers, TRIBO_VERSION_STRING);
    TEST_ASSERT_EQUAL_STRING(TRIBO_PROJECT_VERSION, TRIBO_VERSION_STRING);
}

#include "runners/test_parameters.inc" // main
