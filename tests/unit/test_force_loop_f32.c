#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_q31.h"
#include "tribo/paper_controller.h"

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
    (void)tribo_force_loop_f32_start(&state, &params, false);
}

// --- what must never happen --------------------------------------------------------------------------------------

static void test_loop_takes_whatever_is_no_credible_number_for_a_bad_input(void)
{
    const float bad[]   = {NAN, -NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, 2.0f + 0x1p-22f, -2.0f - 0x1p-22f};
    uint32_t    counted = 0;
    for (int k = 0; k < 1500; k++)
    {
        (void)tribo_force_loop_f32_step(&params, &state, 0.5f, 0.499f, &seen);
    }
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

static void test_loop_recovers_from_a_corrupt_force_with_and_without_a_change_of_params(void)
{
    const tribo_force_loop_f32_params_t other = params;
    for (int change = 0; change <= 1; change++)
    {
        (void)tribo_force_loop_f32_start(&state, &params, false);
        (void)tribo_force_loop_f32_step(&params, &state, 0.5f, 0.5f, &seen);
        state.compensator.arm.force_n = NAN;
        for (int k = 0; k < 3000; k++)
        {
            const float u = tribo_force_loop_f32_step(change ? &other : &params, &state, 0.5f, 0.5f, &seen);
            TEST_ASSERT_TRUE(u >= -2.0f && u <= 2.0f);
        }
        TEST_ASSERT_EQUAL_UINT32(1, state.compensator.arm.clamped);
        TEST_ASSERT_FLOAT_WITHIN(0.5f, 0.0f, seen.compensator.force_n);
    }
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
    memset(&out, 0xa5, sizeof out);
    TEST_ASSERT_EQUAL_INT(status, tribo_force_loop_f32_init(&out, &config));
    TEST_ASSERT_EACH_EQUAL_HEX8(0xa5, &out, sizeof out);
}

static void test_loop_init_refuses_the_papers_controller_at_another_sample_time(void)
{
    tribo_biquad_f32_section_t    copy[2] = {tribo_paper_controller_f32[0], tribo_paper_controller_f32[1]};
    const float                   other[] = {50e-6f, 100e-6f, 250e-6f, 500e-6f, 0.99e-3f, 1.01e-3f, 2e-3f, 20e-3f};
    tribo_force_loop_f32_params_t made;
    for (size_t i = 0; i < sizeof other / sizeof other[0]; i++)
    {
        config.sample_time_s = other[i];
        check_refused(TRIBO_ERR_PAPER_SAMPLE_TIME);
        config.controller.sections = copy; // its numbers, wherever they are
        check_refused(TRIBO_ERR_PAPER_SAMPLE_TIME);
        config = tribo_force_loop_f32_paper();
    }
    copy[1].a2 *= 2.0f; // somebody's own
    config.controller.sections = copy;
    config.sample_time_s       = 500e-6f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&made, &config));
    config.controller.sections      = tribo_paper_controller_f32;
    config.controller.section_count = 1;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&made, &config));
}

// Each thing that matters on a rig is asked for, in the order of the checks.
static void test_a_config_for_a_rig_is_refused_until_what_matters_is_given(void)
{
    static const tribo_biquad_f32_section_t own[] = {TRIBO_BIQUAD_F32(1.0, -0.9, 0.0, -1.0, 0.0)};
    tribo_force_loop_f32_params_t           made;
    config = tribo_force_loop_f32_rig();
    check_refused(TRIBO_ERR_SAMPLE_TIME);
    config.sample_time_s = 0.002f;
    check_refused(TRIBO_ERR_INPUT_MAX);
    config.input_max_n = 60.0f;
    check_refused(TRIBO_ERR_SECTION_COUNT);
    config.controller.sections      = own;
    config.controller.section_count = 1;
    check_refused(TRIBO_ERR_U_MAX);
    config.controller.u_min_n = -50.0f;
    config.controller.u_max_n = 50.0f;
    check_refused(TRIBO_ERR_BREAKAWAY_OFFSET);
    config.compensator.friction.positive = (tribo_breakaway_f32_t){.offset_n = 2.0f, .slope = 0.1f};
    check_refused(TRIBO_ERR_BREAKAWAY_NEGATIVE_OFFSET);
    config.compensator.friction.negative = config.compensator.friction.positive;
    check_refused(TRIBO_ERR_STIFFNESS);
    config.compensator.arm.stiffness = 1e4f;
    check_refused(TRIBO_ERR_INERTIA);
    config.compensator.arm.inertia = 0.5f;
    config.compensator.arm.damping = 100.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&made, &config));
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

static void test_loop_with_a_feedforward_init_writes_nothing_unless_ok(void)
{
    tribo_feedforward_f32_config_t feedforward = tribo_feedforward_f32_default();
    tribo_feedforward_f32_params_t made;
    tribo_force_loop_f32_params_t  untouched;
    memset(&params, 0x5a, sizeof params);
    memset(&made, 0x5a, sizeof made);
    untouched         = params;
    feedforward.trust = 1.1f;
    config.method     = tribo_feedforward_f32_use(&made, &feedforward);
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_force_loop_f32_init(NULL, &config));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_TRUST, tribo_force_loop_f32_init(&params, &config));
    TEST_ASSERT_EQUAL_MEMORY(&untouched, &params, sizeof params);
    TEST_ASSERT_EACH_EQUAL_HEX8(0x5a, &made, sizeof made);
    feedforward.trust = 0.5f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&params, &config));
    TEST_ASSERT_EQUAL_PTR(&made.method, params.method);
    TEST_ASSERT_EQUAL_PTR(&made, tribo_feedforward_f32_of(&params));
    TEST_ASSERT_NULL(params.guard);
}

static void test_loop_init_makes_its_guard_and_refuses_a_part_of_q31(void)
{
    tribo_guard_f32_config_t limits = tribo_guard_f32_default();
    tribo_guard_f32_params_t guard;
    tribo_guard_q31_params_t other;
    config.guard = tribo_guard_f32_use(&guard, &limits);
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&params, &config));
    TEST_ASSERT_EQUAL_PTR(&guard, params.guard);
    TEST_ASSERT_FLOAT_WITHIN(1e-9f, limits.stray_n, guard.stray_n);
    limits.stray_n = NAN;
    check_refused(TRIBO_ERR_GUARD_STRAY);
    config.guard = tribo_guard_f32_use(NULL, &limits);
    check_refused(TRIBO_ERR_NULL);
    config.guard = tribo_guard_q31_use(&other, &limits);
    check_refused(TRIBO_ERR_PART);
}

#include "runners/test_force_loop_f32.inc" // main
