// What only the f32 arithmetic has. What both promise: tests/contract/test_lugre.c.

#include "friction/lugre_f32.h"
#include "tribo/force_loop_f32.h"
#include "tribo/friction_f32.h"

#include "lugre_paper.h"
#include "unity.h"

#include <math.h>

#define H 1.0e-3f

static tribo_lugre_f32_config_t     config;
static tribo_arm_f32_config_t       arm;
static tribo_lugre_f32_params_t     params;
static tribo_friction_f32_params_t  friction;
static tribo_lugre_f32_state_t      state;
static tribo_friction_f32_signals_t seen;

void setUp(void)
{
    const tribo_friction_f32_config_t law = tribo_force_loop_f32_paper().compensator.friction;
    config                                = lugre_paper();
    arm                                   = tribo_force_loop_f32_paper().compensator.arm;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_lugre_f32_init(&params, &config, &arm, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_f32_init(&friction, &law, H));
    tribo_lugre_f32_reset(&state);
}

void tearDown(void)
{
}

static void test_a_bad_input_leaves_the_net_force_and_is_counted(void)
{
    (void)tribo_lugre_f32_step(&params, &friction, &state, 0.105f, 0.1f, &seen);
    const float n = seen.n_n;
    (void)tribo_lugre_f32_step(&params, &friction, &state, NAN, 0.1f, &seen);
    TEST_ASSERT_EQUAL_FLOAT(n, seen.n_n);
    TEST_ASSERT_EQUAL_FLOAT(0.037f, seen.L_n);
    (void)tribo_lugre_f32_step(&params, &friction, &state, -2.0e6f, 0.1f, &seen);
    TEST_ASSERT_EQUAL_FLOAT(n, seen.n_n);
    (void)tribo_lugre_f32_step(&params, &friction, &state, 0.1f, INFINITY, &seen);
    TEST_ASSERT_EQUAL_FLOAT(n, seen.n_n);
    TEST_ASSERT_EQUAL_FLOAT(0.007f, seen.L_n);
    TEST_ASSERT_EQUAL_UINT32(3, state.bad_inputs);
    TEST_ASSERT_TRUE(isfinite(seen.f_n) && isfinite(state.bristle_n));
    tribo_lugre_f32_reset(&state);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, state.n_n);
    TEST_ASSERT_EQUAL_UINT32(0, state.bad_inputs);
}

/// Of no step, but of a flipped bit.
static void test_a_corrupt_state_starts_again_from_rest(void)
{
    static const float corrupt[] = {NAN, INFINITY, -INFINITY, 1.0e30f, -3.0e38f};
    for (unsigned i = 0; i < 2u * sizeof corrupt / sizeof corrupt[0]; i++)
    {
        tribo_lugre_f32_reset(&state);
        *(i % 2u != 0u ? &state.bristle_n : &state.drive_n) = corrupt[i / 2u];
        const float f = tribo_lugre_f32_step(&params, &friction, &state, 0.105f, 0.1f, &seen);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, f);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, state.bristle_n);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, state.drive_n);
        (void)tribo_lugre_f32_step(&params, &friction, &state, 0.105f, 0.1f, &seen);
        TEST_ASSERT_FLOAT_WITHIN(1e-3f, 0.005f, seen.f_n);
    }
}

static void test_init_takes_no_null(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_lugre_f32_init(NULL, &config, &arm, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_lugre_f32_init(&params, NULL, &arm, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_lugre_f32_init(&params, &config, NULL, H));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_bad_input_leaves_the_net_force_and_is_counted);
    RUN_TEST(test_a_corrupt_state_starts_again_from_rest);
    RUN_TEST(test_init_takes_no_null);
    return UNITY_END();
}
