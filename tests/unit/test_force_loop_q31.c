#include "loop/loop_q31.h"
#include "tribo/feedforward_q31.h"
#include "tribo/force_loop_q31.h"

#include "random.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define FULL_SCALE 4.0f

static tribo_force_loop_f32_config_t  config;
static tribo_force_loop_q31_params_t  params;
static tribo_force_loop_q31_state_t   state;
static tribo_force_loop_q31_signals_t seen;

static tribo_status_t init(tribo_force_loop_q31_params_t *out)
{
    const tribo_force_loop_q31_config_t whole = {.loop = config, .full_scale_n = FULL_SCALE};
    return tribo_force_loop_q31_init(out, &whole);
}

void setUp(void)
{
    config = tribo_force_loop_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&params));
    (void)tribo_force_loop_q31_start(&state, &params, false);
}

static int32_t q31(double force_n)
{
    return (int32_t)round(force_n / (double)FULL_SCALE * 2147483648.0);
}

static tribo_force_loop_q31_params_t other_params(void)
{
    tribo_force_loop_q31_params_t other;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&other));
    return other;
}

// --- what must never happen --------------------------------------------------------------------------------------

static void test_loop_takes_inputs_up_to_the_largest_credible_one(void)
{
    const int32_t bad[]   = {q31(2.0) + 1, -q31(2.0) - 1, INT32_MAX, -INT32_MAX, INT32_MIN};
    uint32_t      counted = 0;
    for (int k = 0; k < 1500; k++)
    {
        (void)tribo_force_loop_q31_step(&params, &state, q31(0.5), q31(0.499), &seen);
    }
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
    {
        for (int which = 0; which < 3; which++)
        {
            tribo_force_loop_q31_state_t   twin = state;
            tribo_force_loop_q31_signals_t twin_seen;
            const int32_t coasting = tribo_force_loop_q31_step(&params, &twin, q31(0.5), q31(0.5), &twin_seen);
            const int32_t r        = which != 1 ? bad[i] : q31(0.5);
            const int32_t y        = which != 0 ? bad[i] : q31(0.5);
            TEST_ASSERT_EQUAL_INT32(coasting, tribo_force_loop_q31_step(&params, &state, r, y, &seen)); // e = 0
            TEST_ASSERT_EQUAL_INT32(0, seen.e);
            counted++;
            TEST_ASSERT_EQUAL_UINT32(counted, state.bad_inputs);
        }
    }
    (void)tribo_force_loop_q31_step(&params, &state, q31(2.0), -q31(2.0), &seen); // the ends of what is credible
    (void)tribo_force_loop_q31_step(&params, &state, -q31(2.0), q31(2.0), &seen);
    (void)tribo_force_loop_q31_step(&params, &state, q31(0.5), q31(0.25), &seen);
    TEST_ASSERT_EQUAL_INT32(q31(0.25), seen.e);
    TEST_ASSERT_EQUAL_UINT32(counted, state.bad_inputs);
    state.bad_inputs = UINT32_MAX;
    (void)tribo_force_loop_q31_step(&params, &state, INT32_MIN, 0, &seen);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, state.bad_inputs);
}

static void test_loop_saturates_an_error_and_a_feedforward_beyond_full_scale(void)
{
    config.input_max_n = FULL_SCALE;
    config.gain        = 2.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&params));
    (void)tribo_force_loop_q31_step(&params, &state, INT32_MAX - 1, 1 - INT32_MAX, &seen);
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, seen.e);
    TEST_ASSERT_EQUAL_UINT32(0, state.bad_inputs);
    TEST_ASSERT_EQUAL_UINT32(1, state.saturated);
    state.friction = -q31(2.5);
    (void)tribo_force_loop_q31_step(&params, &state, 0, 0, &seen);
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, seen.friction_term);
    TEST_ASSERT_EQUAL_UINT32(2, state.saturated);
}

static void test_loop_stays_within_its_limits_whatever_comes(void)
{
    const int32_t inputs[]                    = {INT32_MIN, -INT32_MAX, q31(-2.0), -1, 0, 1, q31(2.0), INT32_MAX};
    config.gain                               = 2.0f;
    config.compensator.friction.gravity_n     = 3.9f;
    config.controller.u_max_n                 = 3.0f;
    const tribo_force_loop_q31_params_t other = other_params();
    random_t                            r     = {6};
    for (int k = 0; k < 20000; k++)
    {
        const tribo_force_loop_q31_params_t *p = random_bits(&r) % 50u == 0u ? &other : &params;
        const int32_t                        u =
            tribo_force_loop_q31_step(p, &state, inputs[random_bits(&r) % 8u], inputs[random_bits(&r) % 8u], &seen);
        TEST_ASSERT_TRUE(u >= p->controller.u_min && u <= p->controller.u_max);
    }
    // And with sane inputs it is sane again.
    for (int k = 0; k < 5000; k++)
    {
        (void)tribo_force_loop_q31_step(&params, &state, q31(0.5), q31(0.5), &seen);
    }
    TEST_ASSERT_FALSE(seen.controller.limited);
}

// --- set-up ------------------------------------------------------------------------------------------------------

static void test_loop_with_a_feedforward_init_writes_nothing_unless_ok(void)
{
    config                                     = tribo_force_loop_f32_paper();
    tribo_feedforward_f32_config_t feedforward = tribo_feedforward_f32_default();
    tribo_feedforward_q31_params_t made;
    tribo_force_loop_q31_params_t  untouched;
    tribo_headroom_q31_t           headroom = {.input = -1.0f};
    memset(&params, 0x5a, sizeof params);
    memset(&made, 0x5a, sizeof made);
    untouched                           = params;
    feedforward.trust                   = 1.1f;
    tribo_force_loop_q31_config_t whole = {.loop = config, .full_scale_n = 2.0f, .headroom = &headroom};
    whole.loop.method                   = tribo_feedforward_q31_use(&made, &feedforward);
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_force_loop_q31_init(NULL, &whole));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_TRUST, tribo_force_loop_q31_init(&params, &whole));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_force_loop_q31_init(&params, NULL));
    TEST_ASSERT_EQUAL_MEMORY(&untouched, &params, sizeof params);
    TEST_ASSERT_EACH_EQUAL_HEX8(0x5a, &made, sizeof made);
    TEST_ASSERT_TRUE(headroom.input == -1.0f);
    feedforward.trust = 0.5f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_q31_init(&params, &whole));
    TEST_ASSERT_EQUAL_PTR(&made.method, params.method);
    TEST_ASSERT_EQUAL_PTR(&made, tribo_feedforward_q31_of(&params));
    TEST_ASSERT_TRUE(headroom.input > 0.0f);
    TEST_ASSERT_NULL(params.guard);
}

static void test_loop_init_makes_its_guard_and_refuses_a_part_of_f32(void)
{
    tribo_guard_f32_config_t limits = tribo_guard_f32_default();
    tribo_guard_q31_params_t guard;
    tribo_guard_f32_params_t other;
    config.guard = tribo_guard_q31_use(&guard, &limits);
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&params));
    TEST_ASSERT_EQUAL_PTR(&guard, params.guard);
    limits.turn_n = 0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_GUARD_TURN, init(&params));
    config.guard = tribo_guard_f32_use(&other, &limits);
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_PART, init(&params));
}

static void test_loop_reset_clears_the_counts_of_saturations(void)
{
    memset(&state, 0x5a, sizeof state);
    (void)tribo_force_loop_q31_start(&state, &params, false);
    TEST_ASSERT_EQUAL_UINT32(0, state.saturated);
    TEST_ASSERT_EQUAL_UINT32(0, state.controller.cascade.saturated);
    TEST_ASSERT_EQUAL_UINT32(0, state.compensator.friction.saturated);
    TEST_ASSERT_EQUAL_UINT32(0, state.compensator.arm.saturated);
}

#include "runners/test_force_loop_q31.inc" // main
