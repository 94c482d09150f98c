#include "tribo/force_loop_f32.h"

#include "same.h"
#include "unity.h"

#include <float.h>
#include <math.h>
#include <string.h>

static tribo_force_loop_f32_config_t  config;
static tribo_force_loop_f32_params_t  params;
static tribo_force_loop_f32_state_t   state;
static tribo_force_loop_f32_signals_t seen;

void setUp(void)
{
    config = tribo_force_loop_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&params, &config));
    tribo_force_loop_f32_reset(&state);
}

void tearDown(void)
{
}

/// A plant that is nothing but a delay and some stiction, so that signals move like a real loop's.
static float toy_plant_n;

static float step_with(const tribo_force_loop_f32_params_t *p, int k)
{
    const float r = 0.5f + 0.1f * (float)sin(k * 0.002);
    const float u = tribo_force_loop_f32_step(p, &state, r, toy_plant_n, &seen);
    toy_plant_n += 0.05f * (0.8f * u - toy_plant_n);
    return u;
}

static void run(int ticks)
{
    toy_plant_n = 0.0f;
    for (int k = 0; k < ticks; k++)
    {
        (void)step_with(&params, k);
    }
}

static void test_loop_is_controller_and_compensator_joined_as_in_fig_9(void)
{
    tribo_controller_f32_state_t    controller;
    tribo_controller_f32_signals_t  controller_seen;
    tribo_compensator_f32_state_t   compensator;
    tribo_compensator_f32_signals_t compensator_seen;
    tribo_controller_f32_reset(&controller);
    tribo_compensator_f32_reset(&compensator);
    float f = 0.0f;
    for (int k = 0; k < 5000; k++)
    {
        const float r = 0.5f + 0.2f * (float)sin(k * 0.004);
        const float y = 0.5f + 0.19f * (float)sin(k * 0.004 - 0.1);
        const float u = tribo_controller_f32_step(&params.controller, &controller, r - y, 0.85f * f, &controller_seen);
        const float feedforward = 0.85f * f; // of the tick before
        f                       = tribo_compensator_f32_step(&params.compensator, &compensator, u, &compensator_seen);

        TEST_ASSERT_EQUAL_HEX32(same_bits(u), same_bits(tribo_force_loop_f32_step(&params, &state, r, y, &seen)));
        TEST_ASSERT_SAME_FLOAT(r - y, seen.e_n);
        TEST_ASSERT_SAME_FLOAT(feedforward, seen.feedforward_n);
        TEST_ASSERT_SAME_FLOAT(controller_seen.v_n, seen.controller.v_n);
        TEST_ASSERT_SAME_FLOAT(u, seen.controller.u_n);
        TEST_ASSERT_SAME_FLOAT(f, seen.compensator.friction.f_n);
        TEST_ASSERT_SAME_FLOAT(compensator_seen.force_n, seen.compensator.force_n);
    }
}

static void test_loop_with_gain_0_does_without_compensation(void)
{
    config.gain = 0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&params, &config));
    for (int k = 0; k < 500; k++)
    {
        const float u = step_with(&params, k);
        TEST_ASSERT_SAME_FLOAT(0.0f, seen.feedforward_n);
        TEST_ASSERT_SAME_FLOAT(seen.controller.v_n, u);
    }
    TEST_ASSERT_TRUE(seen.compensator.friction.f_n > 0.01f); // which goes on estimating
}

// The compensator must see u after the limit, or its arm would walk off while u is limited.
static void test_loop_compensator_sees_the_limited_u(void)
{
    config.controller.u_max_n = 0.3f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&params, &config));
    for (int k = 0; k < 5000; k++)
    {
        TEST_ASSERT_TRUE(tribo_force_loop_f32_step(&params, &state, 1.5f, 0.0f, &seen) <= 0.3f);
        TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.3f, seen.compensator.force_n + seen.compensator.friction.n_n); // u = F^ + n
    }
    TEST_ASSERT_EQUAL_UINT32(5000, state.controller.limited_ticks);
}

// --- change of params --------------------------------------------------------------------------------------------

static tribo_force_loop_f32_params_t other_params(void)
{
    tribo_force_loop_f32_params_t other;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&other, &config));
    return other;
}

/// Runs into the middle of things, changes to `to`, and compares with a twin that goes on under the old params: u must
/// be the same in the tick of the change and move off from there without a jump.
static void check_bumpless(const tribo_force_loop_f32_params_t *to, int change_at)
{
    tribo_force_loop_f32_reset(&state);
    run(change_at);
    tribo_force_loop_f32_state_t   twin = state;
    tribo_force_loop_f32_signals_t twin_seen;
    const float                    r = 0.5f + 0.1f * (float)sin(change_at * 0.002);
    const float                    y = toy_plant_n;

    const float old_u = tribo_force_loop_f32_step(&params, &twin, r, y, &twin_seen);
    const float new_u = tribo_force_loop_f32_step(to, &state, r, y, &seen);
    TEST_ASSERT_FLOAT_WITHIN(2e-6f, old_u, new_u);

    const float old_next = tribo_force_loop_f32_step(&params, &twin, r, y, &twin_seen);
    const float new_next = tribo_force_loop_f32_step(to, &state, r, y, &seen);
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, old_next, new_next);
    TEST_ASSERT_EQUAL_PTR(to, state.active);
}

static void test_loop_changes_gain_without_a_bump(void)
{
    config.gain                               = 0.3f;
    const tribo_force_loop_f32_params_t other = other_params();
    for (int k = 200; k < 4000; k += 97)
    {
        check_bumpless(&other, k);
    }
    TEST_ASSERT_TRUE(fabsf(0.55f * seen.compensator.friction.f_n) > 0.01f); // what the bump would have been
}

static void test_loop_changes_friction_and_arm_without_a_bump(void)
{
    config.compensator.friction.positive.slope = 0.2f;
    config.compensator.friction.negative.slope = 0.4f;
    config.compensator.friction.gravity_n      = 0.003f;
    config.compensator.arm.stiffness           = 5.0f;
    config.compensator.friction.pulse_width_s  = 0.005f;
    const tribo_force_loop_f32_params_t other  = other_params();
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
    const tribo_force_loop_f32_params_t other        = other_params();
    for (int k = 200; k < 4000; k += 97)
    {
        check_bumpless(&other, k);
    }
}

static void test_loop_change_to_equal_params_goes_on_as_before(void)
{
    const tribo_force_loop_f32_params_t twin_params = params;
    run(1500);
    tribo_force_loop_f32_state_t twin_state = state;
    for (int k = 0; k < 1000; k++)
    {
        tribo_force_loop_f32_signals_t twin_seen;
        const float                    r     = 0.5f + 0.1f * (float)sin(k * 0.002);
        const float                    plain = tribo_force_loop_f32_step(&params, &twin_state, r, 0.5f, &twin_seen);
        const float                    u     = tribo_force_loop_f32_step(&twin_params, &state, r, 0.5f, &seen);
        TEST_ASSERT_FLOAT_WITHIN(2e-5f, plain, u);
    }
}

static void test_loop_new_limits_hold_in_the_tick_of_the_change(void)
{
    run(1500);
    config.controller.u_max_n                 = 0.1f;
    const tribo_force_loop_f32_params_t other = other_params();
    TEST_ASSERT_TRUE(seen.controller.u_n > 0.2f);
    TEST_ASSERT_SAME_FLOAT(0.1f, tribo_force_loop_f32_step(&other, &state, 0.5f, 0.5f, &seen));
    TEST_ASSERT_TRUE(seen.controller.limited);
}

// --- what must never happen --------------------------------------------------------------------------------------

static void test_loop_coasts_over_a_bad_input_counts_it_and_recovers(void)
{
    const float bad[] = {NAN, -NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, 2.0f + 0x1p-22f, -2.0f - 0x1p-22f};
    run(1500);
    uint32_t counted = 0;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
    {
        for (int which = 0; which < 3; which++)
        {
            tribo_force_loop_f32_state_t   twin = state;
            tribo_force_loop_f32_signals_t twin_seen;
            const float                    coasting = tribo_force_loop_f32_step(&params, &twin, 0.5f, 0.5f, &twin_seen);
            const float                    u        = tribo_force_loop_f32_step(&params,
                                                      &state,
                                                      which != 1 ? bad[i] : 0.5f,
                                                      which != 0 ? bad[i] : 0.5f,
                                                      &seen);
            TEST_ASSERT_SAME_FLOAT(coasting, u); // e = 0
            TEST_ASSERT_SAME_FLOAT(0.0f, seen.e_n);
            counted++;
            TEST_ASSERT_EQUAL_UINT32(counted, state.bad_inputs);
            TEST_ASSERT_EQUAL_UINT32(0, state.controller.bad_inputs);
            TEST_ASSERT_EQUAL_UINT32(0, state.compensator.friction.bad_inputs);
        }
    }
    (void)tribo_force_loop_f32_step(&params, &state, 2.0f, -2.0f, &seen); // the ends of what is credible
    TEST_ASSERT_SAME_FLOAT(4.0f, seen.e_n);
    (void)tribo_force_loop_f32_step(&params, &state, 0.5f, 0.25f, &seen);
    TEST_ASSERT_SAME_FLOAT(0.25f, seen.e_n);
    TEST_ASSERT_EQUAL_UINT32(counted, state.bad_inputs);
}

// u and gravity, each accepted, add up to more than the model takes.
static void test_loop_recovers_from_forces_beyond_its_model(void)
{
    config.input_max_n                    = 1.0e6f;
    config.controller.u_min_n             = -5.0e5f;
    config.controller.u_max_n             = 5.0e5f;
    config.compensator.friction.gravity_n = 6.0e5f;
    config.compensator.friction.positive  = (tribo_breakaway_f32_t){.offset_n = 1.0f, .slope = 0.0f};
    config.compensator.friction.negative  = config.compensator.friction.positive;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&params, &config));
    for (int k = 0; k < 20000; k++)
    {
        (void)tribo_force_loop_f32_step(&params, &state, 1.0e6f, 0.0f, &seen);
        TEST_ASSERT_TRUE(fabsf(seen.compensator.force_n) <= 1.0e6f);
    }
    TEST_ASSERT_TRUE(state.compensator.arm.clamped > 0u);
    for (int k = 0; k < 20000; k++)
    {
        (void)tribo_force_loop_f32_step(&params, &state, 0.0f, 1.0e6f, &seen);
    }
    const uint32_t clamped = state.compensator.arm.clamped;
    (void)tribo_force_loop_f32_step(&params, &state, 0.0f, 1.0e6f, &seen);
    TEST_ASSERT_EQUAL_UINT32(clamped, state.compensator.arm.clamped);
    TEST_ASSERT_EQUAL_UINT32(0, state.compensator.friction.bad_inputs);
    // At rest again: the arm carries u and gravity less what friction takes.
    TEST_ASSERT_FLOAT_WITHIN(seen.compensator.friction.L_n + 1.0f,
                             seen.controller.u_n + 6.0e5f,
                             seen.compensator.force_n);
}

static void test_loop_takes_inputs_to_the_end_of_their_range_and_denormals(void)
{
    (void)tribo_force_loop_f32_step(&params, &state, 2.0f, -2.0f, &seen);
    TEST_ASSERT_SAME_FLOAT(4.0f, seen.e_n);
    (void)tribo_force_loop_f32_step(&params, &state, FLT_TRUE_MIN, -FLT_TRUE_MIN, &seen);
    TEST_ASSERT_SAME_FLOAT(2.0f * FLT_TRUE_MIN, seen.e_n);
    TEST_ASSERT_EQUAL_UINT32(0, state.bad_inputs);
}

// --- set-up ------------------------------------------------------------------------------------------------------

static void check_refused(tribo_status_t status)
{
    tribo_force_loop_f32_params_t out;
    tribo_force_loop_f32_params_t untouched;
    memset(&out, 0xa5, sizeof out);
    memset(&untouched, 0xa5, sizeof untouched);
    TEST_ASSERT_EQUAL_INT(status, tribo_force_loop_f32_init(&out, &config));
    TEST_ASSERT_EQUAL_MEMORY(&untouched, &out, sizeof out);
}

static void test_loop_init_checks_every_field_and_passes_on_what_its_parts_refuse(void)
{
    const tribo_force_loop_f32_config_t good      = config;
    const float                         bad_h[]   = {0.0f, 0.9e-6f, 0.11f, NAN};
    const float                         bad_max[] = {0.0f, -1.0f, 1.01e6f, NAN};
    const float                         bad_eta[] = {-0.01f, 2.01f, NAN, INFINITY};
    for (size_t i = 0; i < 4; i++)
    {
        config.sample_time_s = bad_h[i];
        check_refused(TRIBO_ERR_SAMPLE_TIME);
        config             = good;
        config.input_max_n = bad_max[i];
        check_refused(TRIBO_ERR_INPUT_MAX);
        config      = good;
        config.gain = bad_eta[i];
        check_refused(TRIBO_ERR_GAIN);
        config = good;
    }
    config.controller.u_min_n = 1.0f;
    check_refused(TRIBO_ERR_U_MIN);
    config                            = good;
    config.compensator.friction.k_min = 1.0f;
    check_refused(TRIBO_ERR_K_MIN);
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_force_loop_f32_init(NULL, &config));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_force_loop_f32_init(&params, NULL));
    config      = good;
    config.gain = 2.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&params, &config));
}

static void test_loop_state_and_params_of_one_axis_take_at_most_400_bytes(void)
{
    TEST_ASSERT_TRUE(sizeof(tribo_force_loop_f32_params_t) + sizeof(tribo_force_loop_f32_state_t) <= 400u);
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
    RUN_TEST(test_loop_recovers_from_forces_beyond_its_model);
    RUN_TEST(test_loop_takes_inputs_to_the_end_of_their_range_and_denormals);
    RUN_TEST(test_loop_init_checks_every_field_and_passes_on_what_its_parts_refuse);
    RUN_TEST(test_loop_state_and_params_of_one_axis_take_at_most_400_bytes);
    return UNITY_END();
}
