#include "controller/biquad_f32.h"
#include "controller/biquad_q31.h"
#include "friction/arm_q31.h"
#include "friction/compensator_q31.h"
#include "tribo/force_loop_q31.h"
#include "tribo/friction_q31.h"

#include "unity.h"

#include <string.h>

static tribo_compensator_f32_config_t  config;
static tribo_compensator_q31_params_t  params;
static tribo_compensator_q31_state_t   state;
static tribo_compensator_q31_signals_t seen;

void setUp(void)
{
    config = tribo_force_loop_f32_paper().compensator;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_compensator_q31_init(&params, NULL, &config, 1e-3f, 2.0f));
    tribo_compensator_q31_reset(&state);
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
    memset(&out, 0xa5, sizeof out);
    TEST_ASSERT_EQUAL_INT(status, tribo_compensator_q31_init(&out, NULL, &config, h, full_scale));
    TEST_ASSERT_EACH_EQUAL_HEX8(0xa5, &out, sizeof out);
}

static void test_compensator_init_refuses_what_q31_alone_cannot_hold(void)
{
    const tribo_compensator_f32_config_t good = config;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_compensator_q31_init(NULL, NULL, &config, 1e-3f, 2.0f));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_compensator_q31_init(&params, NULL, NULL, 1e-3f, 2.0f));
    check_refused(TRIBO_ERR_FULL_SCALE, 1e-3f, 0.0f);
    config.arm.damping = 0.0f; // f32 takes it
    check_refused(TRIBO_ERR_DAMPING, 1e-3f, 2.0f);
    config                    = good;
    config.friction.gravity_n = 2.0f;
    check_refused(TRIBO_ERR_GRAVITY, 1e-3f, 2.0f);
}

#include "runners/test_compensator_q31.inc" // main
