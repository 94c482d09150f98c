#include "friction/compensator_f32.h"
#include "tribo/force_loop_f32.h"
#include "tribo/friction_f32.h"

#include "same.h"
#include "unity.h"

#include <math.h>

#define H 1.0e-3f

static tribo_compensator_f32_config_t  config;
static tribo_compensator_f32_params_t  params;
static tribo_compensator_f32_state_t   state;
static tribo_compensator_f32_signals_t seen;

void setUp(void)
{
    config = tribo_force_loop_f32_paper().compensator;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_compensator_f32_init(&params, &config, H));
    tribo_compensator_f32_reset(&state);
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
    TEST_ASSERT_EQUAL_UINT32(0, state.arm.clamped);
}

// F^ beyond any force is corrupt: the arm starts again from rest, so f^ is that of a fresh state in the same tick.
static void test_compensator_restarts_the_arm_from_a_corrupt_force(void)
{
    const float corrupt[] = {NAN, INFINITY, -INFINITY, 1.1e6f, -1.1e6f};
    for (uint32_t i = 0; i < sizeof corrupt / sizeof corrupt[0]; i++)
    {
        tribo_compensator_f32_reset(&state);
        const float f = tribo_compensator_f32_step(&params, &state, 0.005f, &seen);
        tribo_compensator_f32_reset(&state);
        state.arm.force_n = corrupt[i];
        TEST_ASSERT_SAME_FLOAT(f, tribo_compensator_f32_step(&params, &state, 0.005f, &seen));
        TEST_ASSERT_SAME_FLOAT(0.0f, seen.force_n);
    }
}

static void test_compensator_init_checks_pointers(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_compensator_f32_init(NULL, &config, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_compensator_f32_init(&params, NULL, H));
}

#include "runners/test_compensator_f32.inc" // main
