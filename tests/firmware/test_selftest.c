// The power-up self-test: every fault that it is built to find.

#include "app/crc32.h"
#include "app/selftest.h"
#include "unity.h"

#include <string.h>

// --- image ---------------------------------------------------------------------------------------------------------

static uint8_t image[512];

static selftest_seal_t seal_of_image(void)
{
    selftest_seal_t seal = {.magic = SELFTEST_MAGIC, .regions = {{16, 200}, {300, 100}}};
    for (size_t i = 0; i < sizeof image; i++)
    {
        image[i] = (uint8_t)(7u * i);
    }
    seal.crc = crc32_update(crc32_update(0, image + 16, 200), image + 300, 100);
    return seal;
}

static void test_crc32_has_its_check_value(void)
{
    TEST_ASSERT_EQUAL_HEX32(0xcbf43926u, crc32_update(0, "123456789", 9));
    TEST_ASSERT_EQUAL_HEX32(0xcbf43926u, crc32_update(crc32_update(0, "1234", 4), "56789", 5));
}

static void test_image_as_sealed_passes(void)
{
    const selftest_seal_t seal = seal_of_image();
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_NONE, selftest_image(&seal, image));
}

static void test_image_with_any_bit_flipped_fails(void)
{
    const selftest_seal_t seal = seal_of_image();
    for (size_t bit = 0; bit < 8u * sizeof image; bit++)
    {
        const size_t        byte = bit / 8u;
        const drive_fault_t expected =
            (byte >= 16 && byte < 216) || (byte >= 300 && byte < 400) ? DRIVE_FAULT_IMAGE : DRIVE_FAULT_NONE;
        image[byte] ^= (uint8_t)(1u << bit % 8u);
        TEST_ASSERT_EQUAL_INT(expected, selftest_image(&seal, image));
        image[byte] ^= (uint8_t)(1u << bit % 8u);
    }
}

static void test_image_that_is_not_sealed_fails(void)
{
    selftest_seal_t seal = seal_of_image();
    seal.magic           = ~SELFTEST_MAGIC;
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_IMAGE, selftest_image(&seal, image));
    const selftest_seal_t empty = {.magic = SELFTEST_MAGIC}; // 0 is the right CRC of no data
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_IMAGE, selftest_image(&empty, image));
}

// --- RAM -----------------------------------------------------------------------------------------------------------

#define WORDS 64

static uint32_t memory[WORDS];
static size_t   broken_word;
static uint32_t stuck_high, stuck_low;
static uint32_t shorted;      ///< these bits read low unless all are high
static size_t   missing_line; ///< address bit that is not connected; 0: none

static volatile uint32_t *wired(const volatile uint32_t *word)
{
    const size_t place = (size_t)(word - memory);
    return memory + (place & ~missing_line);
}

static uint32_t read_broken(const volatile uint32_t *word)
{
    const volatile uint32_t *real = wired(word);
    if (shorted != 0u && (*real & shorted) != shorted)
    {
        return *real & ~shorted;
    }
    return real == memory + broken_word ? (*real | stuck_high) & ~stuck_low : *real;
}

static void write_broken(volatile uint32_t *word, uint32_t value)
{
    *wired(word) = value;
}

static const selftest_ram_t broken = {.read = read_broken, .write = write_broken};

static void fill(void)
{
    for (uint32_t i = 0; i < WORDS; i++)
    {
        memory[i] = 0x9e3779b9u * (i + 1u);
    }
    broken_word  = 0;
    stuck_high   = 0;
    stuck_low    = 0;
    shorted      = 0;
    missing_line = 0;
}

static void test_good_ram_passes_and_keeps_its_contents(void)
{
    uint32_t before[WORDS];
    fill();
    memcpy(before, memory, sizeof before);
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_NONE, selftest_ram(&broken, memory, WORDS));
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_NONE, selftest_ram(&selftest_ram_real, memory, WORDS));
    TEST_ASSERT_EQUAL_HEX32_ARRAY(before, memory, WORDS);
}

static void test_ram_with_any_bit_stuck_fails(void)
{
    for (size_t word = 0; word < WORDS; word++)
    {
        for (unsigned bit = 0; bit < 32u; bit++)
        {
            fill();
            broken_word = word;
            stuck_high  = 1u << bit;
            TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_RAM, selftest_ram(&broken, memory, WORDS));
            fill();
            broken_word = word;
            stuck_low   = 1u << bit;
            TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_RAM, selftest_ram(&broken, memory, WORDS));
        }
    }
}

static void test_ram_with_two_neighbouring_bits_shorted_fails(void)
{
    for (unsigned distance = 1; distance <= 2u; distance++)
    {
        for (unsigned bit = 0; bit + distance < 32u; bit++)
        {
            fill();
            shorted = (1u << bit) | (1u << (bit + distance));
            TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_RAM, selftest_ram(&broken, memory, 1));
        }
    }
}

static void test_ram_with_any_address_line_missing_fails(void)
{
    for (size_t line = 1; line < WORDS; line *= 2u)
    {
        fill();
        missing_line = line;
        TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_RAM, selftest_ram(&broken, memory, WORDS));
    }
}

static void test_no_ram_at_all_fails(void)
{
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_RAM, selftest_ram(&broken, memory, 0));
}

// --- golden vector -------------------------------------------------------------------------------------------------

static void test_golden_vector_of_the_loop_passes(void)
{
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(SELFTEST_GOLDEN_CRC,
                                    selftest_golden_crc(),
                                    "if the library computes something new");
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_NONE, selftest_golden());
}

// --- all of it -----------------------------------------------------------------------------------------------------

static void test_the_whole_self_test_passes_and_restores_the_ram(void)
{
    const selftest_seal_t seal = seal_of_image();
    uint32_t              before[WORDS];
    fill();
    memcpy(before, memory, sizeof before);
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_NONE, selftest_run(&seal, image, memory, sizeof memory));
    TEST_ASSERT_EQUAL_HEX32_ARRAY(before, memory, WORDS);
}

static void test_the_whole_self_test_returns_the_first_fault(void)
{
    selftest_seal_t seal = seal_of_image();
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_RAM, selftest_run(&seal, image, memory, 0));
    seal.crc ^= 1u;
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_IMAGE, selftest_run(&seal, image, memory, sizeof memory));
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_IMAGE, selftest_run(&seal, image, memory, 0));
}

#include "runners/test_selftest.inc" // main
