// Set-up, and what only the f32 arithmetic has. What both promise: tests/contract/test_feedforward.c.

#include "feedforward/feedforward_f32.h"
#include "tribo/feedforward_f32.h"

#include "same.h"
#include "unity.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define H 1.0e-3f

static tribo_feedforward_f32_config_t  config;
static tribo_compensator_f32_config_t  model;
static tribo_feedforward_f32_params_t  params;
static tribo_friction_f32_params_t     friction;
static tribo_feedforward_f32_state_t   state;
static tribo_feedforward_f32_signals_t signals;

void setUp(void)
{
    config = tribo_feedforward_f32_default();
    model  = tribo_compensator_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_f32_init(&friction, &model.friction, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_feedforward_f32_init(&params, &config, &model, 2.0f, H));
    tribo_feedforward_f32_reset(&params, &state);
}

void tearDown(void)
{
}

static void test_times_shorter_than_a_tick_act_within_it(void)
{
    config.jump_time_s   = 1e-6f;
    config.noise_time_s  = 1e-6f;
    config.offset_time_s = 1e-6f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_feedforward_f32_init(&params, &config, &model, 2.0f, H));
    TEST_ASSERT_SAME_FLOAT(2.0f, params.jump);
    TEST_ASSERT_SAME_FLOAT(1.0f, params.noise_part);
    TEST_ASSERT_SAME_FLOAT(1.0f, params.offset_part);
}

static void check(float *field, float value, tribo_status_t status)
{
    const tribo_feedforward_f32_params_t before = params;
    const float                          kept   = *field;
    *field                                      = value;
    TEST_ASSERT_EQUAL_INT(status, tribo_feedforward_f32_init(&params, &config, &model, 2.0f, H));
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
    *field = kept;
}

static void test_feedforward_init_names_the_field(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_feedforward_f32_init(NULL, &config, &model, 2.0f, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_feedforward_f32_init(&params, NULL, &model, 2.0f, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_feedforward_f32_init(&params, &config, NULL, 2.0f, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SAMPLE_TIME, tribo_feedforward_f32_init(&params, &config, &model, 2.0f, 0.2f));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_INPUT_MAX, tribo_feedforward_f32_init(&params, &config, &model, 0.0f, H));
    check(&config.actuator_pole_rad_per_s, 0.0f, TRIBO_ERR_ACTUATOR_POLE);
    check(&config.sensor_pole_rad_per_s, NAN, TRIBO_ERR_SENSOR_POLE);
    check(&model.arm.stiffness, 0.0f, TRIBO_ERR_STIFFNESS);
    check(&config.slide_filter_time_s, 0.0f, TRIBO_ERR_SLIDE_FILTER);
    check(&config.reversal_n, 0.0f, TRIBO_ERR_REVERSAL_WIDTH);
    check(&config.jump_time_s, NAN, TRIBO_ERR_JUMP_TIME);
    check(&config.lead, 1.1f, TRIBO_ERR_LEAD);
    check(&config.noise_gain, 8.1f, TRIBO_ERR_NOISE_GAIN);
    check(&config.noise_time_s, 0.0f, TRIBO_ERR_NOISE_TIME);
    check(&config.rate_time_s, 0.0f, TRIBO_ERR_RATE_TIME);
    check(&config.rate_max_n_per_s, 0.0f, TRIBO_ERR_RATE_MAX);
    check(&config.offset_time_s, 0.0f, TRIBO_ERR_OFFSET_TIME);
    check(&config.slide_width_n, -1.0f, TRIBO_ERR_SLIDE_WIDTH);
    check(&config.slide_rate_max_n_per_s, NAN, TRIBO_ERR_SLIDE_RATE);
    check(&config.slide_run_in_n, 0.0f, TRIBO_ERR_SLIDE_RUN_IN);
    check(&config.slide_error_max_n, 0.0f, TRIBO_ERR_SLIDE_ERROR);
    check(&config.learning.trust, -1.0f, TRIBO_ERR_LEARNING_TRUST);
    check(&config.hold.gain, 1.0f, TRIBO_ERR_HOLD_GAIN);
}

static void test_a_bad_entry_counts_as_0(void)
{
    tribo_feedforward_f32_enter(&state, NAN);
    (void)tribo_feedforward_f32_before(&params, &friction, &state, 0.4f, 0.4f, &signals);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.0f, tribo_feedforward_f32_added(&params, &state, 0.0f, &signals));
}

static void test_a_bad_u_or_v_measures_nothing(void)
{
    (void)tribo_feedforward_f32_before(&params, &friction, &state, 0.4f, 0.4f, &signals);
    const float added = tribo_feedforward_f32_added(&params, &state, NAN, &signals);
    TEST_ASSERT_SAME_FLOAT(signals.lin_n + signals.f_n - signals.b_n, added);
    const tribo_feedforward_f32_state_t before = state;
    const float                         bad[]  = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 3; i++)
    {
        tribo_feedforward_f32_after(&params, &friction, &state, 0.0f, bad[i], false, &signals);
        tribo_feedforward_f32_after(&params, &friction, &state, bad[i], 0.4f, false, &signals);
    }
    TEST_ASSERT_EQUAL_MEMORY(&before, &state, sizeof state);
}

static void test_what_was_learned_at_a_bad_force_is_that_at_0(void)
{
    static const float bad[] = {NAN, INFINITY, -INFINITY, 1.1e6f, -1.1e6f};
    for (uint32_t d = 0; d < 2u; d++)
    {
        for (int i = 0; i < 5; i++)
        {
            const tribo_feedforward_f32_learned_t at =
                tribo_feedforward_f32_learned(&params, &friction, &state, d, bad[i]);
            TEST_ASSERT_FLOAT_WITHIN(1e-9f, 0.007f, at.L_n);
            TEST_ASSERT_FALSE(at.at_bound);
        }
        // The largest good force counts.
        TEST_ASSERT_FLOAT_WITHIN(1.0f, 3.0e5f, tribo_feedforward_f32_learned(&params, &friction, &state, d, -1e6f).L_n);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_times_shorter_than_a_tick_act_within_it);
    RUN_TEST(test_feedforward_init_names_the_field);
    RUN_TEST(test_a_bad_entry_counts_as_0);
    RUN_TEST(test_a_bad_u_or_v_measures_nothing);
    RUN_TEST(test_what_was_learned_at_a_bad_force_is_that_at_0);
    return UNITY_END();
}
