#include "tribo/force_loop_q31.h"

#include "random.h"
#include "tribo/quantize_q31.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define FULL_SCALE 4.0f

static tribo_force_loop_f32_config_t  config;
static tribo_force_loop_q31_params_t  params;
static tribo_force_loop_q31_state_t   state;
static tribo_force_loop_q31_signals_t seen;

static tribo_status_t init(tribo_force_loop_q31_params_t *out)
{
    return tribo_force_loop_q31_init(out, NULL, &config, FULL_SCALE, NULL);
}

void setUp(void)
{
    config = tribo_force_loop_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&params));
    tribo_force_loop_q31_reset(&state);
}

void tearDown(void)
{
}

static int32_t q31(double force_n)
{
    return (int32_t)round(force_n / (double)FULL_SCALE * 2147483648.0);
}

/// A plant that is nothing but a delay and some stiction, so that signals move like a real loop's.
static int32_t toy_plant;

static int32_t reference(int k)
{
    return q31(0.5 + 0.1 * sin(k * 0.002));
}

static int32_t step_with(const tribo_force_loop_q31_params_t *p, int k)
{
    const int32_t u = tribo_force_loop_q31_step(p, &state, reference(k), toy_plant, &seen);
    toy_plant += (u - u / 5 - toy_plant) / 20;
    return u;
}

static void run(int ticks)
{
    toy_plant = 0;
    for (int k = 0; k < ticks; k++)
    {
        (void)step_with(&params, k);
    }
}

static void test_loop_is_controller_and_compensator_joined_as_in_fig_9(void)
{
    tribo_controller_q31_state_t    controller;
    tribo_controller_q31_signals_t  controller_seen;
    tribo_compensator_q31_state_t   compensator;
    tribo_compensator_q31_signals_t compensator_seen;
    tribo_controller_q31_reset(&controller);
    tribo_compensator_q31_reset(&compensator);
    int32_t f = 0;
    for (int k = 0; k < 5000; k++)
    {
        const int32_t r           = q31(0.5 + 0.2 * sin(k * 0.004));
        const int32_t y           = q31(0.5 + 0.19 * sin(k * 0.004 - 0.1));
        const int32_t feedforward = (int32_t)((int64_t)params.gain * f >> 29); // of the tick before
        const int32_t u =
            tribo_controller_q31_step(&params.controller, &controller, r - y, feedforward, &controller_seen);
        f = tribo_compensator_q31_step(&params.compensator, &compensator, u, &compensator_seen);

        TEST_ASSERT_EQUAL_INT32(u, tribo_force_loop_q31_step(&params, &state, r, y, &seen));
        TEST_ASSERT_EQUAL_INT32(r - y, seen.e);
        TEST_ASSERT_EQUAL_INT32(feedforward, seen.feedforward);
        TEST_ASSERT_EQUAL_INT32(controller_seen.v, seen.controller.v);
        TEST_ASSERT_EQUAL_INT32(u, seen.controller.u);
        TEST_ASSERT_EQUAL_INT32(f, seen.compensator.friction.f);
        TEST_ASSERT_EQUAL_INT32(compensator_seen.force, seen.compensator.force);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.85, ldexp(params.gain, -29));
    TEST_ASSERT_TRUE(f > q31(0.01));
}

static void test_loop_with_gain_0_does_without_compensation(void)
{
    config.gain = 0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&params));
    for (int k = 0; k < 500; k++)
    {
        const int32_t u = step_with(&params, k);
        TEST_ASSERT_EQUAL_INT32(0, seen.feedforward);
        TEST_ASSERT_EQUAL_INT32(seen.controller.v, u);
    }
    TEST_ASSERT_TRUE(seen.compensator.friction.f > q31(0.01)); // which goes on estimating
}

// The compensator must see u after the limit, or its arm would walk off while u is limited.
static void test_loop_compensator_sees_the_limited_u(void)
{
    config.controller.u_max_n = 0.3f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&params));
    for (int k = 0; k < 5000; k++)
    {
        const int32_t u = tribo_force_loop_q31_step(&params, &state, q31(1.5), 0, &seen);
        TEST_ASSERT_EQUAL_INT32(params.controller.u_max, u);
        TEST_ASSERT_EQUAL_INT32(u, seen.compensator.force + seen.compensator.friction.n);
    }
    TEST_ASSERT_EQUAL_UINT32(5000, state.controller.limited_ticks);
}

// --- change of params --------------------------------------------------------------------------------------------

static tribo_force_loop_q31_params_t other_params(void)
{
    tribo_force_loop_q31_params_t other;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&other));
    return other;
}

/// Runs into the middle of things, changes to `to`, and compares with a twin that goes on under the old params: u must
/// be the same in the tick of the change and move off from there without a jump.
static void check_bumpless(const tribo_force_loop_q31_params_t *to, int change_at)
{
    tribo_force_loop_q31_reset(&state);
    run(change_at);
    tribo_force_loop_q31_state_t   twin = state;
    tribo_force_loop_q31_signals_t twin_seen;
    const int32_t                  r = reference(change_at);
    const int32_t                  y = toy_plant;

    const int32_t old_u = tribo_force_loop_q31_step(&params, &twin, r, y, &twin_seen);
    const int32_t new_u = tribo_force_loop_q31_step(to, &state, r, y, &seen);
    TEST_ASSERT_INT32_WITHIN(q31(1e-7), old_u, new_u);

    const int32_t old_next = tribo_force_loop_q31_step(&params, &twin, r, y, &twin_seen);
    const int32_t new_next = tribo_force_loop_q31_step(to, &state, r, y, &seen);
    TEST_ASSERT_INT32_WITHIN(q31(1e-3), old_next, new_next);
    TEST_ASSERT_EQUAL_PTR(to, state.active);
    TEST_ASSERT_EQUAL_UINT32(0, state.saturated + state.controller.cascade.saturated);
}

static void test_loop_changes_gain_without_a_bump(void)
{
    config.gain                               = 0.3f;
    const tribo_force_loop_q31_params_t other = other_params();
    for (int k = 200; k < 4000; k += 97)
    {
        check_bumpless(&other, k);
    }
    TEST_ASSERT_TRUE(seen.compensator.friction.f > q31(0.02)); // what the bump would have been
}

static void test_loop_changes_friction_and_arm_without_a_bump(void)
{
    config.compensator.friction.positive.slope = 0.2f;
    config.compensator.friction.negative.slope = 0.4f;
    config.compensator.friction.gravity_n      = 0.003f;
    config.compensator.arm.stiffness           = 5.0f;
    config.compensator.friction.pulse_width_s  = 0.005f;
    const tribo_force_loop_q31_params_t other  = other_params();
    for (int k = 200; k < 4000; k += 97)
    {
        check_bumpless(&other, k);
    }
}

static void test_loop_changes_the_controller_without_a_bump(void)
{
    static const tribo_biquad_f32_section_t softer[] = {TRIBO_BIQUAD_F32(1.0, -0.5, 0.0, -0.6, 0.0),
                                                        TRIBO_BIQUAD_F32(0.4, -0.39, 0.0, -0.99999, 0.0)};
    config.controller.sections                       = softer;
    const tribo_force_loop_q31_params_t other        = other_params();
    for (int k = 200; k < 4000; k += 97)
    {
        check_bumpless(&other, k);
    }
}

static void test_loop_change_to_equal_params_goes_on_as_before(void)
{
    const tribo_force_loop_q31_params_t twin_params = params;
    run(1500);
    tribo_force_loop_q31_state_t twin_state = state;
    for (int k = 0; k < 1000; k++)
    {
        tribo_force_loop_q31_signals_t twin_seen;
        const int32_t plain = tribo_force_loop_q31_step(&params, &twin_state, reference(k), q31(0.5), &twin_seen);
        const int32_t u     = tribo_force_loop_q31_step(&twin_params, &state, reference(k), q31(0.5), &seen);
        TEST_ASSERT_INT32_WITHIN(q31(1e-6), plain, u);
    }
}

static void test_loop_new_limits_hold_in_the_tick_of_the_change(void)
{
    run(1500);
    config.controller.u_max_n                 = 0.1f;
    const tribo_force_loop_q31_params_t other = other_params();
    TEST_ASSERT_TRUE(seen.controller.u > q31(0.2));
    TEST_ASSERT_EQUAL_INT32(other.controller.u_max,
                            tribo_force_loop_q31_step(&other, &state, q31(0.5), q31(0.5), &seen));
    TEST_ASSERT_TRUE(seen.controller.limited);
}

// --- what must never happen --------------------------------------------------------------------------------------

static void test_loop_coasts_over_a_bad_input_counts_it_and_recovers(void)
{
    const int32_t bad[] = {q31(2.0) + 1, -q31(2.0) - 2, INT32_MAX, -INT32_MAX, INT32_MIN};
    run(1500);
    uint32_t counted = 0;
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
    (void)tribo_force_loop_q31_step(&params, &state, q31(2.0), -q31(2.0) - 1, &seen); // the ends of what is credible
    (void)tribo_force_loop_q31_step(&params, &state, -q31(2.0) - 1, q31(2.0), &seen);
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
    (void)tribo_force_loop_q31_step(&params, &state, INT32_MAX, INT32_MIN, &seen);
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, seen.e);
    TEST_ASSERT_EQUAL_UINT32(0, state.bad_inputs);
    TEST_ASSERT_EQUAL_UINT32(1, state.saturated);
    state.friction = -q31(2.5);
    (void)tribo_force_loop_q31_step(&params, &state, 0, 0, &seen);
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, seen.feedforward);
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

static void test_loop_state_and_params_of_one_axis_take_at_most_480_bytes(void)
{
    const size_t bytes = sizeof(tribo_force_loop_q31_params_t) + sizeof(tribo_force_loop_q31_state_t);
    printf("params and state of one axis: %u bytes\n", (unsigned)bytes);
    TEST_ASSERT_TRUE(bytes <= 480u);
}

static void test_loop_reset_leaves_nothing_of_what_was(void)
{
    memset(&state, 0x5a, sizeof state);
    tribo_force_loop_q31_reset(&state);
    TEST_ASSERT_NULL(state.active);
    TEST_ASSERT_EQUAL_INT32(0, state.friction);
    TEST_ASSERT_EQUAL_UINT32(0, state.bad_inputs);
    TEST_ASSERT_EQUAL_UINT32(0, state.saturated);
    TEST_ASSERT_EQUAL_INT32(0, tribo_force_loop_q31_step(&params, &state, 0, 0, &seen));
    TEST_ASSERT_EQUAL_INT32(0, seen.feedforward);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_loop_is_controller_and_compensator_joined_as_in_fig_9);
    RUN_TEST(test_loop_with_gain_0_does_without_compensation);
    RUN_TEST(test_loop_compensator_sees_the_limited_u);
    RUN_TEST(test_loop_changes_gain_without_a_bump);
    RUN_TEST(test_loop_changes_friction_and_arm_without_a_bump);
    RUN_TEST(test_loop_changes_the_controller_without_a_bump);
    RUN_TEST(test_loop_change_to_equal_params_goes_on_as_before);
    RUN_TEST(test_loop_new_limits_hold_in_the_tick_of_the_change);
    RUN_TEST(test_loop_coasts_over_a_bad_input_counts_it_and_recovers);
    RUN_TEST(test_loop_saturates_an_error_and_a_feedforward_beyond_full_scale);
    RUN_TEST(test_loop_stays_within_its_limits_whatever_comes);
    RUN_TEST(test_loop_state_and_params_of_one_axis_take_at_most_480_bytes);
    RUN_TEST(test_loop_reset_leaves_nothing_of_what_was);
    return UNITY_END();
}
