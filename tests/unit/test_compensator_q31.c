#include "tribo/compensator_q31.h"

#include "tribo/quantize_q31.h"
#include "unity.h"

#include <string.h>

static tribo_compensator_f32_config_t  config;
static tribo_compensator_q31_params_t  params;
static tribo_compensator_q31_state_t   state;
static tribo_compensator_q31_signals_t seen;

void setUp(void)
{
    config = tribo_compensator_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_compensator_q31_init(&params, NULL, &config, 1e-3f, 2.0f));
    tribo_compensator_q31_reset(&state);
}

void tearDown(void)
{
}

static void test_compensator_is_friction_and_arm_joined_as_in_fig_11(void)
{
    tribo_friction_q31_state_t   friction;
    tribo_friction_q31_signals_t friction_seen;
    tribo_arm_q31_state_t        arm;
    tribo_friction_q31_reset(&friction);
    tribo_arm_q31_reset(&arm);
    int32_t u = 0;
    for (int k = 0; k < 5000; k++)
    {
        u += k % 2000 < 1000 ? 700000 : -500000;
        const int32_t force = tribo_arm_q31_force(&arm);
        const int32_t f     = tribo_friction_q31_step(&params.friction, &friction, u, force, &friction_seen);
        (void)tribo_arm_q31_step(&params.arm, &arm, friction_seen.n - f);
        TEST_ASSERT_EQUAL_INT32(f, tribo_compensator_q31_step(&params, &state, u, &seen));
        TEST_ASSERT_EQUAL_INT32(force, seen.force);
        TEST_ASSERT_EQUAL_INT32(f, seen.friction.f);
        TEST_ASSERT_EQUAL_INT32(friction_seen.n, seen.friction.n);
        TEST_ASSERT_EQUAL_INT64(arm.force, state.arm.force);
    }
    TEST_ASSERT_TRUE(seen.force > 100000000);
    TEST_ASSERT_EQUAL_UINT32(0, state.friction.saturated + state.arm.saturated);
}

static void test_compensator_reset_is_rest(void)
{
    for (int k = 0; k < 100; k++)
    {
        (void)tribo_compensator_q31_step(&params, &state, INT32_MAX, &seen);
    }
    tribo_compensator_q31_reset(&state);
    TEST_ASSERT_EQUAL_INT32(0, tribo_compensator_q31_step(&params, &state, 0, &seen));
    TEST_ASSERT_EQUAL_INT32(0, seen.force);
    TEST_ASSERT_EQUAL_INT32(0, seen.friction.rise);
    TEST_ASSERT_EQUAL_UINT32(0, state.arm.saturated);
}

static void test_compensator_stands_wherever_full_scale_inputs_take_it(void)
{
    for (int k = 0; k < 20000; k++)
    {
        const int32_t u = k / 100 % 2 == 0 ? INT32_MIN : INT32_MAX;
        const int32_t f = tribo_compensator_q31_step(&params, &state, u, &seen);
        TEST_ASSERT_TRUE(f <= seen.friction.L && f >= -seen.friction.L);
    }
    for (int k = 0; k < 1000; k++)
    {
        (void)tribo_compensator_q31_step(&params, &state, 0, &seen);
    }
    TEST_ASSERT_EQUAL_INT32(0, state.arm.force_change);
    TEST_ASSERT_EQUAL_INT32(seen.friction.n, seen.friction.f); // it sticks
}

static void check_refused(tribo_status_t status, float h, float full_scale)
{
    tribo_compensator_q31_params_t out;
    tribo_compensator_q31_params_t untouched;
    memset(&out, 0xa5, sizeof out);
    memset(&untouched, 0xa5, sizeof untouched);
    TEST_ASSERT_EQUAL_INT(status, tribo_compensator_q31_init(&out, NULL, &config, h, full_scale));
    TEST_ASSERT_EQUAL_MEMORY(&untouched, &out, sizeof out);
}

static void test_compensator_init_passes_on_what_its_parts_refuse(void)
{
    const tribo_compensator_f32_config_t good = config;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_compensator_q31_init(NULL, NULL, &config, 1e-3f, 2.0f));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_compensator_q31_init(&params, NULL, NULL, 1e-3f, 2.0f));
    check_refused(TRIBO_ERR_SAMPLE_TIME, 0.0f, 2.0f);
    check_refused(TRIBO_ERR_FULL_SCALE, 1e-3f, 0.0f);
    config.friction.k_min = 0.0f;
    check_refused(TRIBO_ERR_K_MIN, 1e-3f, 2.0f);
    config             = good;
    config.arm.damping = 0.0f; // f32 takes it
    check_refused(TRIBO_ERR_DAMPING, 1e-3f, 2.0f);
    config                    = good;
    config.friction.gravity_n = 2.0f;
    check_refused(TRIBO_ERR_GRAVITY, 1e-3f, 2.0f);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_compensator_is_friction_and_arm_joined_as_in_fig_11);
    RUN_TEST(test_compensator_reset_is_rest);
    RUN_TEST(test_compensator_stands_wherever_full_scale_inputs_take_it);
    RUN_TEST(test_compensator_init_passes_on_what_its_parts_refuse);
    return UNITY_END();
}
