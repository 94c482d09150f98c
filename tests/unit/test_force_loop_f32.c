#include "tribo/feedforward_f32.h"

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
            TEST_ASSERT_EQUAL_UINT32(0, state.compensator.friction.paper.bad_inputs);
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
    TEST_ASSERT_EQUAL_UINT32(0, state.compensator.friction.paper.bad_inputs);
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
        tribo_force_loop_f32_reset(&state);
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

static void test_loop_with_a_feedforward_init_writes_nothing_unless_ok(void)
{
    tribo_feedforward_f32_config_t feedforward = tribo_feedforward_f32_default();
    tribo_feedforward_f32_params_t made;
    tribo_force_loop_f32_params_t  untouched;
    memset(&params, 0x5a, sizeof params);
    memset(&made, 0x5a, sizeof made);
    untouched         = params;
    feedforward.trust = 1.1f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_force_loop_feedforward_f32_init(NULL, &made, &config, &feedforward));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_TRUST,
                          tribo_force_loop_feedforward_f32_init(&params, &made, &config, &feedforward));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_force_loop_feedforward_f32_init(&params, &made, NULL, &feedforward));
    TEST_ASSERT_EQUAL_MEMORY(&untouched, &params, sizeof params);
    TEST_ASSERT_EACH_EQUAL_HEX8(0x5a, &made, sizeof made);
    feedforward.trust = 0.5f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_feedforward_f32_init(&params, &made, &config, &feedforward));
    TEST_ASSERT_EQUAL_PTR(&made.method, params.method);
    TEST_ASSERT_EQUAL_PTR(&made, tribo_feedforward_f32_of(&params));
    tribo_force_loop_feedforward_f32_attach(&state, NULL);
    TEST_ASSERT_NULL(state.memory);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_loop_takes_whatever_is_no_credible_number_for_a_bad_input);
    RUN_TEST(test_loop_recovers_from_forces_beyond_its_model);
    RUN_TEST(test_loop_recovers_from_a_corrupt_force_with_and_without_a_change_of_params);
    RUN_TEST(test_loop_takes_inputs_to_the_end_of_their_range_and_denormals);
    RUN_TEST(test_loop_init_checks_every_field_and_passes_on_what_its_parts_refuse);
    RUN_TEST(test_loop_with_a_feedforward_init_writes_nothing_unless_ok);
    return UNITY_END();
}
