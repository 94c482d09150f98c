// A single bit that flips in RAM: what the loop computes may be wrong for a while, but it goes on.

#include ARITH_HEADER
#include "unity.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>

static tribo_force_loop_f32_config_t config;
static loop_t                        loop;

void setUp(void)
{
    config = tribo_force_loop_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
}

void tearDown(void)
{
}

static double tick(int k)
{
    const double u = loop_step(&loop, 0.5 + 0.1 * sin(k * 0.002), 0.5 + 0.099 * sin(k * 0.002 - 0.01)).u;
    TEST_ASSERT_EQUAL_UINT32(0, loop_bad_inputs(&loop));
    return u;
}

static void flip(void *object, uint32_t bit)
{
    unsigned char *const bytes = object;
    bytes[bit / 8u] ^= (unsigned char)(1u << bit % 8u);
}

// Whatever a limit has become, u is a number: a limit that is none does not limit.
static void test_loop_with_a_flipped_bit_in_a_limit_gives_a_number(void)
{
    const float limits[] = {0.75f, 1.0f, 1.5f, 2.0f}; // of 1.5 a bit makes a NaN, of 1.0 an infinity
    for (uint32_t i = 0; i < 4u; i++)
    {
        config.controller.u_min_n = -limits[i];
        config.controller.u_max_n = limits[i];
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
        for (uint32_t bit = 0; bit < 64u; bit++)
        {
            void *const limit = bit < 32u ? loop_u_max(&loop) : loop_u_min(&loop);
            loop_reset(&loop);
            flip(limit, bit % 32u);
            for (int k = 0; k < 20; k++)
            {
                TEST_ASSERT_TRUE(isfinite(tick(k)));
            }
            flip(limit, bit % 32u);
        }
    }
}

// It is no change of params: there are no old ones to look at.
static void test_loop_with_a_flipped_bit_in_its_active_params_goes_on(void)
{
    for (uint32_t bit = 0; bit < 8u * sizeof(void *); bit++)
    {
        loop_reset(&loop);
        for (int k = 0; k < 200; k++)
        {
            (void)tick(k);
        }
        flip(&loop.state.active, bit);
        for (int k = 200; k < 220; k++)
        {
            const double u = tick(k);
            TEST_ASSERT_TRUE(u >= (double)config.controller.u_min_n && u <= (double)config.controller.u_max_n);
            TEST_ASSERT_EQUAL_PTR(&loop.params, loop.state.active);
        }
    }
}

// Counts and pointers decide where the loop reads.
static void test_loop_with_a_flipped_bit_in_a_count_or_a_null_table_stays_in_its_params(void)
{
    void *const at[]   = {&loop.params.controller.cascade.count, &loop.params.compensator.friction.table};
    uint32_t    bits[] = {8u * sizeof loop.params.controller.cascade.count, 8u * sizeof(void *)};
    for (uint32_t i = 0; i < 2u; i++)
    {
        for (uint32_t bit = 0; bit < bits[i]; bit++)
        {
            loop_reset(&loop);
            flip(at[i], bit);
            for (int k = 0; k < 20; k++)
            {
                TEST_ASSERT_TRUE(isfinite(tick(k)));
            }
            flip(at[i], bit);
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_loop_with_a_flipped_bit_in_a_count_or_a_null_table_stays_in_its_params);
    RUN_TEST(test_loop_with_a_flipped_bit_in_a_limit_gives_a_number);
    RUN_TEST(test_loop_with_a_flipped_bit_in_its_active_params_goes_on);
    return UNITY_END();
}
