// What only the f32 arithmetic has. What both promise: tests/contract/test_breakaway_learning.c.

#include "feedforward/breakaway_learning_f32.h"

#include "unity.h"

#include <math.h>

#define POSITIVE TRIBO_BREAKAWAY_POSITIVE
#define NEGATIVE TRIBO_BREAKAWAY_NEGATIVE

static tribo_breakaway_learning_f32_params_t params;
static tribo_breakaway_learning_f32_state_t  learning;

void setUp(void)
{
    const tribo_breakaway_learning_f32_config_t config = tribo_breakaway_learning_f32_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_breakaway_learning_f32_init(&params, &config));
    tribo_breakaway_learning_f32_reset(&params, &learning);
}

void tearDown(void)
{
}

static void test_a_bad_prior_counts_as_the_smallest(void)
{
    const float bad[] = {NAN, INFINITY, -INFINITY, 2.1e7f, 0.0f};
    for (int i = 0; i < 5; i++)
    {
        const tribo_breakaway_learning_f32_signals_t at =
            tribo_breakaway_learning_f32_at(&params, &learning, NEGATIVE, bad[i]);
        TEST_ASSERT_FLOAT_WITHIN(1e-12f, 1.0e-6f, at.L_n);
    }
    TEST_ASSERT_EQUAL_FLOAT(2.0e7f, tribo_breakaway_learning_f32_at(&params, &learning, NEGATIVE, 2.0e7f).L_n);
}

static void test_a_slide_of_any_length_brings_the_priors_variance_back_at_once(void)
{
    for (int k = 0; k < 1000; k++)
    {
        breakaway_learning_f32_step(&params, &learning, POSITIVE, 1e-4f, 0.1f, 0.13f);
    }
    breakaway_learning_f32_step(&params, &learning, NEGATIVE, 1e3f, 0.1f, 0.1f);
    for (uint32_t d = 0; d < 2u; d++)
    {
        const tribo_breakaway_learning_f32_signals_t at = tribo_breakaway_learning_f32_at(&params, &learning, d, 0.1f);
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, 1.0f, at.relative_variance);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_bad_prior_counts_as_the_smallest);
    RUN_TEST(test_a_slide_of_any_length_brings_the_priors_variance_back_at_once);
    return UNITY_END();
}
