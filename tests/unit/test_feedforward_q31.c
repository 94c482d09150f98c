// Set-up, and what only the Q31 arithmetic has. What both promise: tests/contract/test_feedforward.c.

#include "feedforward/feedforward_q31.h"
#include "tribo/feedforward_q31.h"

#include "random.h"
#include "unity.h"

#include <math.h>

#define H  1.0e-3f
#define FS 2.0f

static tribo_feedforward_f32_config_t  config;
static tribo_compensator_f32_config_t  model;
static tribo_feedforward_q31_params_t  params;
static tribo_friction_q31_params_t     friction;
static tribo_breakaway_point_q31_t     table[TRIBO_BREAKAWAY_POINTS_MAX];
static tribo_feedforward_q31_state_t   state;
static tribo_feedforward_q31_signals_t signals;

void setUp(void)
{
    config = tribo_feedforward_f32_default();
    model  = tribo_compensator_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_q31_init(&friction, table, &model.friction, H, FS));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_feedforward_q31_init(&params, &config, &model, 2.0f, H, FS));
    tribo_feedforward_q31_reset(&params, &state);
}

void tearDown(void)
{
}

static void check(float *field, float value, tribo_status_t status)
{
    const tribo_feedforward_q31_params_t before = params;
    const float                          kept   = *field;
    *field                                      = value;
    TEST_ASSERT_EQUAL_INT(status, tribo_feedforward_q31_init(&params, &config, &model, 2.0f, H, FS));
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
    *field = kept;
}

static void test_feedforward_init_names_the_field(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_feedforward_q31_init(NULL, &config, &model, 2.0f, H, FS));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_feedforward_q31_init(&params, NULL, &model, 2.0f, H, FS));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_FULL_SCALE, tribo_feedforward_q31_init(&params, &config, &model, 2.0f, H, 0.0f));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_INPUT_MAX, tribo_feedforward_q31_init(&params, &config, &model, 2.1f, H, FS));
    check(&config.reversal_n, 1e-6f, TRIBO_ERR_REVERSAL_WIDTH);
    check(&config.reversal_n, 0.6f, TRIBO_ERR_REVERSAL_WIDTH);
    check(&config.noise_time_s, 200.0f, TRIBO_ERR_NOISE_TIME);
    check(&config.rate_time_s, 200.0f, TRIBO_ERR_RATE_TIME);
    check(&config.rate_max_n_per_s, 16.0f, TRIBO_ERR_RATE_MAX);
    check(&config.rate_max_n_per_s, 1e-3f, TRIBO_ERR_RATE_MAX);
    check(&config.offset_time_s, 1.9e-3f, TRIBO_ERR_OFFSET_TIME);
    check(&config.slide_width_n, 0.6f, TRIBO_ERR_SLIDE_WIDTH);
    check(&config.slide_rate_max_n_per_s, 4.0f, TRIBO_ERR_SLIDE_RATE);
    check(&config.slide_run_in_n, 0.6f, TRIBO_ERR_SLIDE_RUN_IN);
    check(&config.slide_error_max_n, 1e-6f, TRIBO_ERR_SLIDE_ERROR);
    check(&config.slide_filter_time_s, 11.0f, TRIBO_ERR_SLIDE_FILTER);
    check(&config.learning.weight_n, 1e-6f, TRIBO_ERR_LEARNING_WEIGHT);
    check(&config.hold.margin_travel_n, 1e-4f, TRIBO_ERR_HOLD_MARGIN_TRAVEL);
    check(&config.actuator_pole_rad_per_s, 2.0f, TRIBO_ERR_LEAD); // r goes over FS/2 within its lag
    check(&config.actuator_pole_rad_per_s, 9e-3f, TRIBO_ERR_ACTUATOR_POLE);
    check(&config.sensor_pole_rad_per_s, 9e-3f, TRIBO_ERR_SENSOR_POLE);
    config.rate_max_n_per_s = 2e-3f;
    check(&config.actuator_pole_rad_per_s, 0.0152f, TRIBO_ERR_LEAD); // over 65,536 ticks
}

static void test_the_offset_is_bounded_by_four_inputs_or_full_scale(void)
{
    TEST_ASSERT_EQUAL_INT32(INT32_C(1) << 29, params.offset_max);
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_feedforward_q31_init(&params, &config, &model, 0.25f, H, FS));
    TEST_ASSERT_EQUAL_INT32(INT32_C(1) << 28, params.offset_max);
}

static void test_a_lag_of_many_ticks_leads_as_it_should(void)
{
    config.actuator_pole_rad_per_s = 0.5f; // 2,000 ticks
    config.rate_max_n_per_s        = 0.25f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_feedforward_q31_init(&params, &config, &model, 2.0f, H, FS));
    int32_t r = 0;
    for (int k = 0; k < 1000; k++)
    {
        r += 107374; // 0.1 mN a tick, 0.1 N/s
        (void)tribo_feedforward_q31_before(&params, &friction, &state, r, r, &signals);
        (void)tribo_feedforward_q31_added(&params, &state, 0, &signals);
        tribo_feedforward_q31_after(&params, &friction, &state, 0, r, false, &signals);
    }
    const double ahead = (signals.lin - signals.reached) / 536870912.0 * (double)FS;
    TEST_ASSERT_DOUBLE_WITHIN(2e-3 * 0.2, 0.1 * (2.0 + 0.0288 / 3.84), ahead);
}

static void test_what_was_learned_ends_at_full_scale(void)
{
    model.friction.positive.slope = 0.999f; // over full scale with the offset
    model.friction.negative.slope = 2.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_q31_init(&friction, table, &model.friction, H, FS));
    for (uint32_t d = 0; d < 2u; d++)
    {
        static const int32_t end[] = {INT32_MIN, -INT32_MAX, INT32_MAX};
        for (int i = 0; i < 3; i++)
        {
            const tribo_feedforward_q31_learned_t at =
                tribo_feedforward_q31_learned(&params, &friction, &state, d, end[i]);
            TEST_ASSERT_UINT32_WITHIN(4, UINT32_C(1) << 29, at.L);
            TEST_ASSERT_UINT32_WITHIN(256, UINT32_C(1) << 31, at.relative_variance); // 1, rounded in Q28
        }
    }
}

static void test_no_sum_overflows_at_the_ends_of_the_scale(void)
{
    random_t             r        = {31};
    static const int32_t end[]    = {INT32_MIN, INT32_MAX, -INT32_MAX, 0, 1, -1, 1 << 30, -(1 << 30)};
    model.friction.positive.slope = 2.0f; // L beyond full scale
    model.friction.negative.slope = 0.9f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_q31_init(&friction, table, &model.friction, H, FS));
    for (int k = 0; k < 200000; k++)
    {
        const int32_t e = tribo_feedforward_q31_before(&params,
                                                       &friction,
                                                       &state,
                                                       end[random_bits(&r) % 8u],
                                                       end[random_bits(&r) % 8u],
                                                       &signals);
        const int32_t v = end[random_bits(&r) % 8u];
        const int32_t a = tribo_feedforward_q31_added(&params, &state, v, &signals);
        tribo_feedforward_q31_after(&params, &friction, &state, v, end[random_bits(&r) % 8u], k % 5 == 0, &signals);
        TEST_ASSERT_TRUE(e >= -INT32_MAX && a >= -INT32_MAX);
        TEST_ASSERT_TRUE(signals.f <= 1 << 29 && signals.f >= -(1 << 29));
        TEST_ASSERT_TRUE(signals.b <= 1 << 29 && signals.b >= -(1 << 29));
    }
    TEST_ASSERT_TRUE(state.bad_inputs > 1000u);
}

static void test_the_last_bits_of_inputs_mirror_too(void)
{
    static tribo_feedforward_q31_state_t mirror;
    tribo_feedforward_q31_signals_t      mirror_signals;
    random_t                             r  = {41};
    int32_t                              at = 0;
    tribo_feedforward_q31_reset(&params, &mirror);
    for (int k = 0; k < 20000; k++)
    {
        at += (int32_t)random_between(&r, -1e5, 1.1e5);
        const int32_t y = at + (int32_t)random_between(&r, -1e6, 1e6);
        const int32_t v = (int32_t)random_between(&r, -1e8, 1e8);
        const int32_t e = tribo_feedforward_q31_before(&params, &friction, &state, at, y, &signals);
        TEST_ASSERT_EQUAL_INT32(-e,
                                tribo_feedforward_q31_before(&params, &friction, &mirror, -at, -y, &mirror_signals));
        const int32_t a = tribo_feedforward_q31_added(&params, &state, v, &signals);
        TEST_ASSERT_EQUAL_INT32(-a, tribo_feedforward_q31_added(&params, &mirror, -v, &mirror_signals));
        tribo_feedforward_q31_after(&params, &friction, &state, v, v + a, false, &signals);
        tribo_feedforward_q31_after(&params, &friction, &mirror, -v, -v - a, false, &mirror_signals);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_feedforward_init_names_the_field);
    RUN_TEST(test_the_offset_is_bounded_by_four_inputs_or_full_scale);
    RUN_TEST(test_a_lag_of_many_ticks_leads_as_it_should);
    RUN_TEST(test_the_last_bits_of_inputs_mirror_too);
    RUN_TEST(test_what_was_learned_ends_at_full_scale);
    RUN_TEST(test_no_sum_overflows_at_the_ends_of_the_scale);
    return UNITY_END();
}
