#include "tribo/compensator_f32.h"

#include "same.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define H 1.0e-3f

static tribo_compensator_f32_config_t  config;
static tribo_compensator_f32_params_t  params;
static tribo_compensator_f32_state_t   state;
static tribo_compensator_f32_signals_t seen;

void setUp(void)
{
    config = tribo_compensator_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_compensator_f32_init(&params, &config, H));
    tribo_compensator_f32_reset(&state);
}

void tearDown(void)
{
}

static void test_compensator_is_friction_and_arm_joined_as_in_fig_11(void)
{
    tribo_friction_f32_state_t   friction;
    tribo_friction_f32_signals_t friction_seen;
    tribo_arm_f32_state_t        arm;
    tribo_friction_f32_reset(&friction);
    tribo_arm_f32_reset(&arm);
    config.friction.gravity_n = 0.01f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_compensator_f32_init(&params, &config, H));

    for (int k = 0; k < 5000; k++)
    {
        const float u = (float)(0.4 + 0.3 * sin(k * 0.004));
        const float F = arm.force_n;
        const float f = tribo_friction_f32_step(&params.friction, &friction, u, F, &friction_seen);
        (void)tribo_arm_f32_step(&params.arm, &arm, u - F + 0.01f - f);

        TEST_ASSERT_SAME_FLOAT(f, tribo_compensator_f32_step(&params, &state, u, &seen));
        TEST_ASSERT_SAME_FLOAT(F, seen.force_n); // at the start of the tick
        TEST_ASSERT_SAME_FLOAT(f, seen.friction.f_n);
        TEST_ASSERT_SAME_FLOAT(friction_seen.n_n, seen.friction.n_n);
    }
}

static void test_compensator_force_follows_u_minus_breakaway_while_it_slides(void)
{
    for (int k = 0; k <= 60000; k++)
    {
        (void)tribo_compensator_f32_step(&params, &state, 1.0e-5f * (float)k, &seen);
    }
    // u = F + 0.007 + 0.3 F
    TEST_ASSERT_FLOAT_WITHIN(2e-4f, (0.6f - 0.007f) / 1.3f, seen.force_n);
}

static void test_compensator_rides_out_a_bad_input(void)
{
    for (int k = 0; k < 1000; k++)
    {
        (void)tribo_compensator_f32_step(&params, &state, 0.5f, &seen);
    }
    const float f = seen.friction.f_n;
    for (uint32_t k = 1; k <= 100u; k++)
    {
        TEST_ASSERT_FLOAT_WITHIN(1e-5f,
                                 f,
                                 tribo_compensator_f32_step(&params, &state, k % 2u != 0u ? NAN : INFINITY, &seen));
        TEST_ASSERT_EQUAL_UINT32(k, state.friction.bad_inputs);
    }
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, f, tribo_compensator_f32_step(&params, &state, 0.5f, &seen));
    TEST_ASSERT_EQUAL_UINT32(0, state.arm.bad_inputs);
}

static void check_refused(tribo_status_t status, float h)
{
    tribo_compensator_f32_params_t out;
    tribo_compensator_f32_params_t untouched;
    memset(&out, 0xa5, sizeof out);
    memset(&untouched, 0xa5, sizeof untouched);
    TEST_ASSERT_EQUAL_INT(status, tribo_compensator_f32_init(&out, &config, h));
    TEST_ASSERT_EQUAL_MEMORY(&untouched, &out, sizeof out);
}

static void test_compensator_init_passes_on_what_its_parts_refuse(void)
{
    check_refused(TRIBO_ERR_SAMPLE_TIME, 0.0f);
    config.arm.stiffness = NAN;
    check_refused(TRIBO_ERR_STIFFNESS, H);
    config.friction.m = NAN;
    check_refused(TRIBO_ERR_M, H);
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_compensator_f32_init(NULL, &config, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_compensator_f32_init(&params, NULL, H));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_compensator_is_friction_and_arm_joined_as_in_fig_11);
    RUN_TEST(test_compensator_force_follows_u_minus_breakaway_while_it_slides);
    RUN_TEST(test_compensator_rides_out_a_bad_input);
    RUN_TEST(test_compensator_init_passes_on_what_its_parts_refuse);
    return UNITY_END();
}
