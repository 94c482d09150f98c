// What only the Q31 arithmetic has. What both promise: tests/contract/test_breakaway_learning.c.

#include "feedforward/breakaway_learning_f32.h"
#include "feedforward/breakaway_learning_q31.h"

#include "random.h"
#include "runs.h"
#include "unity.h"

#include <math.h>

#define POSITIVE TRIBO_BREAKAWAY_POSITIVE
#define NEGATIVE TRIBO_BREAKAWAY_NEGATIVE
#define FS       2.0
#define UNIT     (FS / 536870912.0) // N

static tribo_breakaway_learning_f32_config_t config;
static tribo_breakaway_learning_q31_params_t params;
static tribo_breakaway_learning_q31_state_t  learning;

void setUp(void)
{
    config = tribo_breakaway_learning_f32_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_breakaway_learning_q31_init(&params, &config, (float)FS));
    tribo_breakaway_learning_q31_reset(&params, &learning);
}

void tearDown(void)
{
}

static uint32_t units(double force_n)
{
    return (uint32_t)lround(force_n / UNIT);
}

static tribo_breakaway_learning_q31_signals_t at(uint32_t direction, double prior)
{
    return tribo_breakaway_learning_q31_at(&params, &learning, direction, units(prior));
}

static void test_learning_takes_extremes_without_leaving_its_ranges(void)
{
    random_t       r        = {12};
    const uint32_t prior[]  = {1, 2, 1000, 1u << 20, (1u << 29) - 1u};
    const int32_t  z[]      = {-(1 << 30), 1 << 30, 0, 1, -1, 1 << 20};
    const uint32_t travel[] = {0, 1, 1000, 1u << 20};
    for (int k = 0; k < RUNS(200000, 20000); k++)
    {
        const uint32_t p = prior[random_bits(&r) % 5u];
        breakaway_learning_q31_step(&params,
                                    &learning,
                                    (uint32_t)random_bits(&r) % 2u,
                                    travel[random_bits(&r) % 4u],
                                    p,
                                    z[random_bits(&r) % 6u]);
        for (uint32_t d = 0; d < 2u; d++)
        {
            const tribo_breakaway_learned_q31_t *of = &learning.of[d];
            TEST_ASSERT_TRUE(of->scale <= 3 << 28 && of->scale >= -(3 << 28));
            TEST_ASSERT_TRUE(of->offset <= 3 << 28 && of->offset >= -(3 << 28));
            TEST_ASSERT_TRUE(of->ss <= (1 << 30) + 64 && of->ss >= -64 && of->oo <= (1 << 30) + 64 && of->oo >= -64);
            const tribo_breakaway_learning_q31_signals_t s = tribo_breakaway_learning_q31_at(&params, &learning, d, p);
            TEST_ASSERT_TRUE(s.L <= 1u << 29 && s.weighted <= s.L && s.relative_variance < 1u << 31);
        }
    }
}

static void test_bounds_are_exact_to_the_last_bit(void)
{
    learning.of[POSITIVE].offset = 3 << 28;
    TEST_ASSERT_TRUE(tribo_breakaway_learning_q31_is_at_bound(&params, &learning, POSITIVE, units(0.1)));
    learning.of[POSITIVE].offset = (3 << 28) - 1;
    TEST_ASSERT_FALSE(tribo_breakaway_learning_q31_is_at_bound(&params, &learning, POSITIVE, units(0.1)));
    learning.of[POSITIVE].scale = (3 << 28) - 1; // L over 3 times: 1 + 3 0.4 + 3 0.9
    TEST_ASSERT_TRUE(tribo_breakaway_learning_q31_is_at_bound(&params, &learning, POSITIVE, units(0.011)));
    TEST_ASSERT_UINT32_WITHIN(2, 3u * units(0.011), at(POSITIVE, 0.011).L);
}

static void test_a_prior_beyond_full_scale_counts_as_the_nearest(void)
{
    TEST_ASSERT_FALSE(tribo_breakaway_learning_q31_is_at_bound(&params, &learning, NEGATIVE, UINT32_MAX));
    TEST_ASSERT_EQUAL_UINT32(at(NEGATIVE, 1.99).L > 0u, 1);
    learning.of[NEGATIVE].scale = 3 << 27;
    TEST_ASSERT_EQUAL_UINT32(1u << 29, tribo_breakaway_learning_q31_at(&params, &learning, NEGATIVE, UINT32_MAX).L);
    TEST_ASSERT_EQUAL_UINT32(1u, tribo_breakaway_learning_q31_at(&params, &learning, POSITIVE, 0).L);
}

static void test_relative_variance_ends_at_1_whatever_the_covariance(void)
{
    for (int32_t ss = INT32_C(1) << 30; ss > 0; ss /= 2)
    {
        learning.of[POSITIVE].ss = INT32_MAX - ss + 1;
        learning.of[POSITIVE].oo = INT32_MAX;
        TEST_ASSERT_UINT32_WITHIN(256, INT32_MAX, at(POSITIVE, 0.1).relative_variance);
        TEST_ASSERT_UINT32_WITHIN(2, (uint32_t)(at(POSITIVE, 0.1).L * (1.0 - 0.5)), at(POSITIVE, 0.1).weighted);
    }
}

static void check(float *field, float value, tribo_status_t status)
{
    const tribo_breakaway_learning_q31_params_t before = params;
    const float                                 kept   = *field;
    *field                                             = value;
    TEST_ASSERT_EQUAL_INT(status, tribo_breakaway_learning_q31_init(&params, &config, (float)FS));
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
    *field = kept;
}

static void test_learning_init_refuses_what_it_cannot_hold(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_FULL_SCALE, tribo_breakaway_learning_q31_init(&params, &config, 0.0f));
    check(&config.scale_sd, 1.1f, TRIBO_ERR_LEARNING_SCALE_SD);
    check(&config.offset_sd_n, 1e-6f, TRIBO_ERR_LEARNING_OFFSET_SD);
    check(&config.offset_sd_n, 0.6f, TRIBO_ERR_LEARNING_OFFSET_SD);
    check(&config.weight_n, 1e-6f, TRIBO_ERR_LEARNING_WEIGHT);
    check(&config.weight_n, 0.2f, TRIBO_ERR_LEARNING_WEIGHT);
    check(&config.forgetting_per_n, 17.0f, TRIBO_ERR_LEARNING_FORGETTING);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_learning_takes_extremes_without_leaving_its_ranges);
    RUN_TEST(test_bounds_are_exact_to_the_last_bit);
    RUN_TEST(test_a_prior_beyond_full_scale_counts_as_the_nearest);
    RUN_TEST(test_relative_variance_ends_at_1_whatever_the_covariance);
    RUN_TEST(test_learning_init_refuses_what_it_cannot_hold);
    return UNITY_END();
}
