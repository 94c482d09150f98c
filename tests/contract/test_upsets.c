// A single bit that flips in RAM: what the loop computes may be wrong for a while, but it goes on.

#include ARITH_HEADER
#include "unity.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>

static tribo_force_loop_f32_config_t config;
static loop_t                        loop;
static uint32_t                      found; // corrupt pointers

void setUp(void)
{
    found  = 0;
    config = tribo_force_loop_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
}

static double tick(int k)
{
    const double u = loop_step(&loop, 0.5 + 0.1 * sin(k * 0.002), 0.5 + 0.099 * sin(k * 0.002 - 0.01)).u;
    TEST_ASSERT_EQUAL_UINT32(found, loop_bad_inputs(&loop));
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
        found = 0;
        for (int k = 0; k < 200; k++)
        {
            (void)tick(k);
        }
        flip(&loop.state.active, bit);
        found = 1;
        for (int k = 200; k < 220; k++)
        {
            const double u = tick(k);
            TEST_ASSERT_TRUE(u >= (double)config.controller.u_min_n && u <= (double)config.controller.u_max_n);
            TEST_ASSERT_EQUAL_PTR(&loop.params, loop.state.active);
        }
    }
}

// Counts and pointers decide where the loop reads; slopes beyond 1 send Q31 where it looks for a table.
static void test_loop_with_a_flipped_bit_in_a_count_or_a_null_table_stays_in_its_params(void)
{
    config.compensator.friction.positive.slope = 1.5f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
    void *const at[]   = {&loop.params.controller.cascade.count,
                          &loop.params.compensator.friction.table,
                          &loop.params.compensator.friction.table_length};
    uint32_t    bits[] = {8u * sizeof loop.params.controller.cascade.count, 8u * sizeof(void *), 8u};
    for (uint32_t i = 0; i < 3u; i++)
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

// A change of params walks through the sections of the old and of the new ones.
static void test_loop_with_a_flipped_bit_in_a_count_changes_params(void)
{
    loop_t next = loop;
    for (uint32_t i = 0; i < 2u; i++)
    {
        loop_t *const changed = i == 0u ? &loop : &next;
        for (uint32_t bit = 0; bit < 8u * sizeof changed->params.controller.cascade.count; bit++)
        {
            loop_reset(&loop);
            (void)tick(0);
            flip(&changed->params.controller.cascade.count, bit);
            next.state = loop.state;
            TEST_ASSERT_TRUE(isfinite(loop_step(&next, 0.5, 0.4).u));
            TEST_ASSERT_EQUAL_PTR(&next.params, next.state.active);
            flip(&changed->params.controller.cascade.count, bit);
        }
    }
}

// Each is counted where it is found: the active params once, as they are replaced, the others in each tick.
static void test_corrupt_pointers_in_the_state_are_counted(void)
{
    const tribo_feedforward_f32_config_t feedforward = tribo_feedforward_f32_default();
    guard_t                              guard;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_feedforward(&loop, &config, &feedforward));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, guard_init(&guard, (double)config.sample_time_s));
    loop_guard(&loop, &guard);
    void *const    at[]       = {&loop.state.active, &loop.state.memory};
    const uint32_t expected[] = {1, 20};
    for (uint32_t i = 0; i < 2u; i++)
    {
        for (uint32_t bit = 0; bit < 8u * sizeof(void *); bit++)
        {
            loop.state.bad_inputs = 0;
            (void)tick(0);
            flip(at[i], bit);
            for (int k = 0; k < 20; k++)
            {
                const double term = loop_step(&loop, 0.5 + 0.01 * k, 0.4).feedforward;
                TEST_ASSERT_TRUE(at[i] != &loop.state.memory || term == 0.0);
            }
            TEST_ASSERT_EQUAL_UINT32(expected[i], loop_bad_inputs(&loop));
            if (i > 0u)
            {
                flip(at[i], bit);
            }
        }
    }
}

// At rest, where n[k-1] = 0 becomes the smallest number or -0.
static void test_loop_with_a_flipped_bit_anywhere_in_its_state_keeps_its_limits(void)
{
    for (uint32_t bit = 0; bit < 8u * sizeof loop.state; bit++)
    {
        loop_reset(&loop);
        flip(&loop.state, bit);
        for (int k = 0; k < 20; k++)
        {
            const double r = k < 10 ? 0.0 : 0.5;
            const double u = loop_step(&loop, r, 0.0).u;
            TEST_ASSERT_TRUE(u >= (double)config.controller.u_min_n && u <= (double)config.controller.u_max_n);
        }
    }
}

#include "runners/test_upsets.inc" // main
