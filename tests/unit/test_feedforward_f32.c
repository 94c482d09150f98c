// Set-up, and what only the f32 arithmetic has. What both promise: tests/contract/test_feedforward.c.

#include "loop/loop_f32.h"
#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_f32.h"

#include "same.h"
#include "unity.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#define H 1.0e-3f

static tribo_feedforward_f32_config_t config;
static tribo_compensator_f32_config_t model;
static tribo_feedforward_f32_params_t params;
static tribo_friction_f32_params_t    friction;
static tribo_feedforward_f32_state_t  state;
static tribo_feedforward_f32_rig_t    rig;

static tribo_status_t init(float input_max, float h)
{
    return tribo_feedforward_f32_init(&params, &config, &model.arm, &friction, input_max, 0.5f, h);
}

static tribo_force_loop_f32_functions_t fed;

void setUp(void)
{
    tribo_feedforward_f32_method(&fed);
    config = tribo_feedforward_f32_default();
    model  = tribo_force_loop_f32_paper().compensator;
    rig    = (tribo_feedforward_f32_rig_t){.actuator_pole_rad_per_s = 200.0f,
                                           .sensor_pole_rad_per_s   = 55.0f,
                                           .arm                     = &model.arm,
                                           .friction                = &friction,
                                           .usual_force_n           = 0.5f,
                                           .sample_time_s           = H};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_f32_init(&friction, &model.friction, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(2.0f, H));
    tribo_feedforward_f32_reset(&state);
}

void tearDown(void)
{
}

/// B is 0.157 N here, tau 12.5 ms: the numbers of docs/feedforward.md.
static void test_the_papers_rig_has_the_numbers_of_the_design(void)
{
    TEST_ASSERT_FLOAT_WITHIN(1e-9f, 0.5e-3f, params.reversal_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 14.2727e-3f, 1.0f / params.stop_per_n[3]);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 5.35227e-3f, 1.0f / params.stop_per_n[2]);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 2.0071e-3f, 1.0f / params.stop_per_n[1]);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.752663e-3f, 1.0f / params.stop_per_n[0]);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 2.0f / 26.25f, params.jump);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 3.5f, params.lead);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.5f, params.distrust);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 12.5e-3f, params.lag_s);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 1.0f / 250.0f, params.noise_part);
    TEST_ASSERT_FLOAT_WITHIN(1e-10f, 1e-6f, params.noise_floor_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.0f / 11.0f, params.rate_part);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 2e-3f, params.step_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.0f / 13.5f, params.lag_part);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.18126925f, params.actuator_part);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.05351485f, params.sensor_part);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.0f / 11.0f, params.observer_part);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 7.5f, params.damping);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 3.0f, params.jump_lag);
    TEST_ASSERT_FLOAT_WITHIN(1e-2f, 4000.0f, params.measured_per_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-9f, 0.05e-3f, params.travel_half_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 5e-3f, params.slip_n); // 10 ticks
    TEST_ASSERT_FLOAT_WITHIN(1e-8f, 1e-3f, params.travel_max_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-8f, 2e-3f, params.weighing_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, 50.0f, params.doubt_per_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 10.0f, params.margin_per_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.1f, params.forgetting_per_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.0300191f, params.constant_sd_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.157f, params.constant_max_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 8.0f, params.offset_max_n);
    TEST_ASSERT_EQUAL_UINT32(200, params.still_ticks);
    TEST_ASSERT_EQUAL_UINT32(200, params.quick_ticks);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 1.0f / 301.0f, params.deadband_part);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.25f, params.effort_part); // 10 ms of 40
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 1.57e-3f, params.effort_half_n);
}

static void test_what_is_given_is_not_derived(void)
{
    config.reversal_n       = 1e-3f;
    config.presliding_n     = 30e-3f;
    config.jump_time_s      = 1e-6f; // at once
    config.forgetting_per_n = 1.0f;
    config.still_time_s     = 0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(2.0f, H));
    TEST_ASSERT_SAME_FLOAT(1e-3f, params.reversal_n);
    TEST_ASSERT_SAME_FLOAT(1.0f / 30e-3f, params.stop_per_n[3]);
    TEST_ASSERT_SAME_FLOAT(2.0f, params.jump);
    TEST_ASSERT_SAME_FLOAT(1.0f, params.forgetting_per_n);
    TEST_ASSERT_EQUAL_UINT32(0, params.still_ticks);
}

static void test_a_slow_tick_lengthens_times(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(2.0f, 0.02f));
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.01f, params.noise_part);          // 100 ticks
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.0f / 3.0f, params.rate_part);     // 2 ticks
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.0f / 6.0f, params.observer_part); // 5 ticks
    config.still_time_s = 1e-3f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(2.0f, 0.02f));
    TEST_ASSERT_EQUAL_UINT32(1, params.still_ticks);
    config.still_time_s = 2.46e-3f; // to the nearest
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(2.0f, H));
    TEST_ASSERT_EQUAL_UINT32(2, params.still_ticks);
    config.still_time_s = 2.54e-3f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(2.0f, H));
    TEST_ASSERT_EQUAL_UINT32(3, params.still_ticks);
}

static void check(float *field, float value, tribo_status_t status)
{
    const tribo_feedforward_f32_params_t before = params;
    const float                          kept   = *field;
    *field                                      = value;
    TEST_ASSERT_EQUAL_INT(status, init(2.0f, H));
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
    *field = kept;
}

static void test_feedforward_init_names_the_field(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL,
                          tribo_feedforward_f32_init(NULL, &config, &model.arm, &friction, 2.0f, 0.5f, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL,
                          tribo_feedforward_f32_init(&params, NULL, &model.arm, &friction, 2.0f, 0.5f, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_feedforward_f32_init(&params, &config, NULL, &friction, 2.0f, 0.5f, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL,
                          tribo_feedforward_f32_init(&params, &config, &model.arm, NULL, 2.0f, 0.5f, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SAMPLE_TIME, init(2.0f, 0.2f));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_INPUT_MAX, init(0.0f, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_USUAL_FORCE,
                          tribo_feedforward_f32_init(&params, &config, &model.arm, &friction, 2.0f, NAN, H));
    check(&config.actuator_pole_rad_per_s, 0.0f, TRIBO_ERR_ACTUATOR_POLE);
    check(&config.actuator_pole_rad_per_s, 5.1e4f, TRIBO_ERR_ACTUATOR_POLE); // 51 in a tick
    check(&config.sensor_pole_rad_per_s, NAN, TRIBO_ERR_SENSOR_POLE);
    check(&config.sensor_pole_rad_per_s, 5.1e4f, TRIBO_ERR_SENSOR_POLE);
    config.sensor_pole_rad_per_s = 4.9e4f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(2.0f, H));
    config.sensor_pole_rad_per_s = 55.0f;
    check(&config.reversal_n, -1e-3f, TRIBO_ERR_REVERSAL_WIDTH);
    check(&config.reversal_n, 0.9e-9f, TRIBO_ERR_REVERSAL_WIDTH);
    check(&config.presliding_n, NAN, TRIBO_ERR_PRESLIDING);
    check(&config.presliding_n, 0.9e-9f, TRIBO_ERR_PRESLIDING);
    config.reversal_n   = 1e-9f;
    config.presliding_n = 1e-9f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(2.0f, H));
    config = tribo_feedforward_f32_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(2.0f, H));
    check(&config.jump_time_s, NAN, TRIBO_ERR_JUMP_TIME);
    check(&config.jump_lead, 1.1f, TRIBO_ERR_JUMP_LEAD);
    check(&config.trust, -0.1f, TRIBO_ERR_TRUST);
    check(&config.forgetting_per_n, -1.0f, TRIBO_ERR_FORGETTING);
    check(&config.still_time_s, 1.1e3f, TRIBO_ERR_STILL_TIME);
}

static void test_a_bad_entry_counts_as_0(void)
{
    state.mode                            = TRIBO_FEEDFORWARD_RESTART;
    tribo_feedforward_f32_memory_t memory = {.state = state};
    fed.enter(&memory, NAN, true);
    TEST_ASSERT_SAME_FLOAT(0.0f, memory.state.tick.term_n);
    TEST_ASSERT_EQUAL_UINT8(TRIBO_FEEDFORWARD_ENTER, memory.state.mode);
}

static void test_what_was_learned_at_a_bad_force_is_that_at_0(void)
{
    static const float bad[] = {NAN, INFINITY, -INFINITY, 1.1e6f, -1.1e6f};
    for (uint32_t d = 0; d < 2u; d++)
    {
        for (int i = 0; i < 5; i++)
        {
            const tribo_feedforward_f32_learned_t at = tribo_feedforward_f32_learned(&friction, &state, d, bad[i]);
            TEST_ASSERT_FLOAT_WITHIN(1e-9f, 0.007f, at.L_n);
            TEST_ASSERT_FALSE(at.at_bound);
        }
        // The largest good force counts.
        TEST_ASSERT_FLOAT_WITHIN(1.0f, 3.0e5f, tribo_feedforward_f32_learned(&friction, &state, d, -1e6f).L_n);
    }
}

#define TURNED (offsetof(tribo_feedforward_f32_state_t, turned_n) / sizeof(float))

/// A state that is no longer a number is forgotten, counted, and u goes on.
static void test_a_state_that_is_no_number_is_forgotten_or_heals(void)
{
    tribo_force_loop_f32_config_t         loop_config = tribo_force_loop_f32_paper();
    static tribo_force_loop_f32_params_t  loop;
    static tribo_force_loop_f32_state_t   running;
    static tribo_feedforward_f32_memory_t memory;
    for (size_t at = 0; at < sizeof memory.state / sizeof(float); at++)
    {
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_feedforward_f32_init(&loop, &params, &loop_config, &config));
        tribo_force_loop_f32_reset(&running);
        tribo_feedforward_f32_reset(&memory.state);
        tribo_force_loop_feedforward_f32_attach(&running, &memory);
        float y = 0.3f;
        for (int k = 0; k < 4000; k++)
        {
            const float r = 0.3f + (k < 2000 ? 1e-5f * (float)k : 0.04f - 1e-5f * (float)k);
            if (k == 1500)
            {
                const float nothing = NAN;
                memcpy((char *)&memory.state + at * sizeof(float), &nothing, sizeof nothing);
                memory.state.tick.term_n = at == TURNED ? NAN : memory.state.tick.term_n; // with a sum that is none
                memory.state.offset_n    = at == TURNED ? NAN : memory.state.offset_n;
            }
            const float u = tribo_force_loop_f32_step(&loop, &running, r, y, NULL);
            TEST_ASSERT_TRUE(fabsf(u) <= 2.0f);
            y += 0.05f * (r - y);
        }
        const tribo_feedforward_f32_state_t *const s = &memory.state;
        TEST_ASSERT_TRUE(isfinite(s->tick.e_n) && isfinite(s->f_n) && isfinite(s->tick.term_n) &&
                         isfinite(s->offset_n));
        TEST_ASSERT_TRUE(isfinite(s->learned.weight[0]) && isfinite(s->learned.use[0]) && isfinite(s->learned.doubt));
        TEST_ASSERT_TRUE(isfinite(s->observer.force_n) && isfinite(s->observer.difference_n));
        TEST_ASSERT_TRUE(isfinite(s->noise_n) && isfinite(s->observer.noise_n) && isfinite(s->learned.covariance[0]));
        TEST_ASSERT_TRUE(s->mode >= TRIBO_FEEDFORWARD_START && s->mode <= TRIBO_FEEDFORWARD_HOLD);
    }
}

/// A first tick that finds its memory corrupt adds nothing of the run before.
static void test_what_is_forgotten_as_it_starts_adds_nothing(void)
{
    tribo_force_loop_f32_config_t         loop_config = tribo_force_loop_f32_paper();
    static tribo_force_loop_f32_params_t  loop;
    static tribo_feedforward_f32_memory_t memory;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_feedforward_f32_init(&loop, &params, &loop_config, &config));
    tribo_feedforward_f32_reset(&memory.state);
    memory.state.tick.term_n        = 0.5f;
    memory.state.learned.constant_n = NAN;
    (void)fed.error(&loop, &memory, 0.3f, 0.3f, 1.0f);
    TEST_ASSERT_EQUAL_UINT32(1, memory.state.forgotten);
    TEST_ASSERT_SAME_FLOAT(0.0f, fed.term(&loop, &memory, 0.0f));
}

/// A difference that is no number: the observer starts again at the reading of this tick.
static void test_an_observer_that_is_lost_starts_again_at_y(void)
{
    tribo_force_loop_f32_config_t         loop_config = tribo_force_loop_f32_paper();
    static tribo_force_loop_f32_params_t  loop;
    static tribo_force_loop_f32_state_t   running;
    static tribo_feedforward_f32_memory_t memory;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_feedforward_f32_init(&loop, &params, &loop_config, &config));
    tribo_force_loop_f32_reset(&running);
    tribo_feedforward_f32_reset(&memory.state);
    tribo_force_loop_feedforward_f32_attach(&running, &memory);
    float y = 0.3f;
    for (int k = 0; k < 500 || memory.state.learning.stage != 0u; k++)
    {
        y += 1e-4f;
        (void)tribo_force_loop_f32_step(&loop, &running, y, y, NULL);
    }
    memory.state.observer.difference_n = NAN;
    (void)tribo_force_loop_f32_step(&loop, &running, y, y + 1e-4f, NULL);
    TEST_ASSERT_EQUAL_FLOAT(y + 1e-4f, memory.state.observer.force_n);
    TEST_ASSERT_EQUAL_FLOAT(y + 1e-4f, memory.state.learning.travelled_n);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, memory.state.learning.friction_n);
}

static void test_a_tuned_config_has_the_derived_numbers(void)
{
    const tribo_feedforward_f32_config_t tuned = tribo_feedforward_f32_tuned(&rig);
    TEST_ASSERT_FLOAT_WITHIN(1e-9f, 0.5e-3f, tuned.reversal_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 14.2727e-3f, tuned.presliding_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.02625f, tuned.jump_time_s);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.1f, tuned.forgetting_per_n);
    const tribo_feedforward_f32_params_t before = params;
    config                                      = tuned;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(2.0f, H));
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
    rig.actuator_pole_rad_per_s = 120.0f;
    rig.sensor_pole_rad_per_s   = 30.0f;
    TEST_ASSERT_EQUAL_FLOAT(120.0f, tribo_feedforward_f32_tuned(&rig).actuator_pole_rad_per_s);
    TEST_ASSERT_EQUAL_FLOAT(30.0f, tribo_feedforward_f32_tuned(&rig).sensor_pole_rad_per_s);
}

static void test_a_tuned_guard_follows_breakaway_lag_and_noise(void)
{
    const tribo_guard_f32_config_t usual = tribo_guard_f32_default();
    tribo_guard_f32_config_t       tuned = tribo_guard_f32_tuned(&rig);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f * usual.turn_n, usual.turn_n, tuned.turn_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f * usual.stray_n, usual.stray_n, tuned.stray_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f * usual.quick_time_s, usual.quick_time_s, tuned.quick_time_s);
    rig.noise_n = 5.0e-3f;
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 40.0e-3f, tribo_guard_f32_tuned(&rig).stray_n);
    rig.sample_time_s = 0.02f;
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.4f, tribo_guard_f32_tuned(&rig).quick_time_s);
    rig.sample_time_s = 1.0e-6f;
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.1f, tribo_guard_f32_tuned(&rig).quick_time_s);
    rig.usual_force_n = 1.0f; // breakaway there: 0.307 N
    rig.noise_n       = 0.0f;
    tuned             = tribo_guard_f32_tuned(&rig);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.307f / 3.14f, tuned.turn_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.307f / 15.7f, tuned.stray_n);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_the_papers_rig_has_the_numbers_of_the_design);
    RUN_TEST(test_what_is_given_is_not_derived);
    RUN_TEST(test_a_slow_tick_lengthens_times);
    RUN_TEST(test_feedforward_init_names_the_field);
    RUN_TEST(test_a_bad_entry_counts_as_0);
    RUN_TEST(test_what_was_learned_at_a_bad_force_is_that_at_0);
    RUN_TEST(test_a_state_that_is_no_number_is_forgotten_or_heals);
    RUN_TEST(test_what_is_forgotten_as_it_starts_adds_nothing);
    RUN_TEST(test_an_observer_that_is_lost_starts_again_at_y);
    RUN_TEST(test_a_tuned_config_has_the_derived_numbers);
    RUN_TEST(test_a_tuned_guard_follows_breakaway_lag_and_noise);
    return UNITY_END();
}
