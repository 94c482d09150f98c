// Set-up, and what only the f32 arithmetic has. What both promise: tests/contract/test_feedforward.c.

#include "feedforward/learner.h"
#include "loop/loop_f32.h"
#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_f32.h"

#include "same.h"
#include "unity.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#define H 1.0e-3f

static tribo_feedforward_f32_config_t   config;
static tribo_compensator_f32_config_t   model;
static tribo_feedforward_f32_params_t   params;
static tribo_friction_f32_params_t      friction;
static tribo_force_loop_f32_functions_t fed;

/// At a usual force of 0.5 N.
static tribo_status_t init(float input_max, float h)
{
    return tribo_feedforward_f32_init(&params, &config, &model.arm, &friction, input_max, 0.5f, h);
}

void setUp(void)
{
    tribo_feedforward_f32_method(&fed);
    config = tribo_feedforward_f32_default();
    model  = tribo_force_loop_f32_paper().compensator;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_f32_init(&friction, &model.friction, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(2.0f, H));
}

/// Learned values refer to breakaway with all points of its table, gravity and presliding, not to limits or rates.
static void test_the_rig_is_that_of_the_numbers_which_learned_values_refer_to(void)
{
    tribo_breakaway_point_f32_t table[] = {{0.0f, 0.01f, 0.01f}, {5.0f, 0.4f, 0.3f}};
    const uint32_t              first   = params.learning.rig;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(3.0f, 2.0f * H));
    TEST_ASSERT_EQUAL_UINT32(first, params.learning.rig);
    friction.gravity_n = -0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(2.0f, H));
    TEST_ASSERT_EQUAL_UINT32(first, params.learning.rig);
    friction.table        = table;
    friction.table_length = 2;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(2.0f, H));
    const uint32_t with_table = params.learning.rig;
    TEST_ASSERT_TRUE(with_table != first);
    float *const numbers[] = {&table[1].force_n, &table[1].positive_n, &table[1].negative_n};
    for (uint32_t i = 0; i < 3u; i++)
    {
        const float was = *numbers[i];
        *numbers[i]     = 2.0f * was;
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(2.0f, H));
        TEST_ASSERT_TRUE(params.learning.rig != with_table);
        *numbers[i] = was;
    }
}

/// B is 0.157 N here, tau 12.5 ms: the numbers of docs/feedforward.md.
static void test_the_papers_rig_has_the_numbers_of_the_design(void)
{
    const tribo_feedforward_learning_t *const learning = &params.learning;
    TEST_ASSERT_FLOAT_WITHIN(1e-9f, 0.5e-3f, params.reversal);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 14.2727e-3f, 1.0f / params.stop_gain[1]);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 5.35227e-3f, 1.0f / params.stop_gain[0]);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 2.0f / 26.25f, params.jump);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 3.5f, params.lead_gain);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 12.5f, params.lag_gain);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 7.5f, params.damping_gain);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 2e-3f, params.step);
    TEST_ASSERT_FLOAT_WITHIN(1e-10f, 1e-6f, params.noise_floor);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 1.0f / 301.0f, params.noise_part);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 1.0f / 301.0f, params.slow_part);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.0f / 11.0f, params.fast_part);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.0f / 13.5f, params.lag_part);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.18126925f, params.actuator_part);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.05351485f, params.sensor_part);
    TEST_ASSERT_FLOAT_WITHIN(1e-8f, 0.01f / 12.51f, params.leak_part); // 10 ticks of 1,000 tau
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.5f, params.trust);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 8.0f, params.offset_max);
    TEST_ASSERT_EQUAL_UINT32(200, params.still_ticks);
    TEST_ASSERT_EQUAL_UINT32(300, params.quick_ticks);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.157f, learning->breakaway_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-2f, 4000.0f, learning->per_n[0]);
    TEST_ASSERT_SAME_FLOAT(params.stop_gain[0], learning->per_n[1]);
    TEST_ASSERT_SAME_FLOAT(params.stop_gain[1], learning->per_n[2]);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.4f, learning->deviation[0]);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.55f, learning->deviation[1]);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.55f, learning->deviation[2]);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.0471f, learning->deviation[3]);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.1f, learning->deviation[4]);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 3.9375f, learning->jump_lag);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.1f, learning->forgetting_per_n);
    TEST_ASSERT_SAME_FLOAT(0.5f, learning->trust);
    TEST_ASSERT_SAME_FLOAT(1.0f, learning->unit_n);
}

/// A sanity bound is no property of the rig.
static void test_the_bound_of_inputs_scales_nothing(void)
{
    tribo_force_loop_f32_config_t loop_config = tribo_force_loop_f32_paper();
    tribo_force_loop_f32_params_t loop;
    loop_config.method = tribo_feedforward_f32_use(&params, &config);
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&loop, &loop_config));
    const tribo_feedforward_f32_params_t before = params;
    loop_config.input_max_n                     = 2000.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&loop, &loop_config));
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.157f, params.learning.breakaway_n); // of a quarter of the largest command
    params.input_max  = before.input_max;
    params.offset_max = before.offset_max;
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
    loop_config.controller.u_min_n = -4.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&loop, &loop_config));
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.307f, params.learning.breakaway_n);
}

static void test_what_is_given_is_not_derived(void)
{
    config.reversal_n       = 1e-3f;
    config.presliding_n     = 30e-3f;
    config.jump_time_s      = 1e-6f; // at once
    config.forgetting_per_n = 1.0f;
    config.still_time_s     = 0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(2.0f, H));
    TEST_ASSERT_SAME_FLOAT(1e-3f, params.reversal);
    TEST_ASSERT_SAME_FLOAT(1.0f / 30e-3f, params.stop_gain[1]);
    TEST_ASSERT_SAME_FLOAT(2.0f, params.jump);
    TEST_ASSERT_SAME_FLOAT(1.0f, params.learning.forgetting_per_n);
    TEST_ASSERT_EQUAL_UINT32(0, params.still_ticks);
}

static void test_a_slow_tick_lengthens_times(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(2.0f, 0.02f));
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.0f / 101.0f, params.noise_part); // 100 ticks
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.0f / 6.0f, params.fast_part);    // 5 ticks
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
    tribo_force_loop_f32_config_t loop = tribo_force_loop_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL,
                          tribo_feedforward_f32_init(NULL, &config, &model.arm, &friction, 2.0f, 0.5f, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL,
                          tribo_feedforward_f32_init(&params, NULL, &model.arm, &friction, 2.0f, 0.5f, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_feedforward_f32_init(&params, &config, NULL, &friction, 2.0f, 0.5f, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL,
                          tribo_feedforward_f32_init(&params, &config, &model.arm, NULL, 2.0f, 0.5f, H));
    loop.method = tribo_feedforward_f32_use(NULL, &config);
    tribo_force_loop_f32_params_t made;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_force_loop_f32_init(&made, &loop));
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
    tribo_feedforward_f32_memory_t memory;
    tribo_feedforward_f32_reset(&memory.state);
    fed.enter(&memory, NAN, true);
    TEST_ASSERT_SAME_FLOAT(0.0f, memory.state.tick.term_n);
    TEST_ASSERT_EQUAL_UINT8(TRIBO_FEEDFORWARD_ENTER, memory.state.mode);
}

static void test_what_was_learned_at_a_bad_force_is_that_at_0(void)
{
    static const float             bad[]       = {NAN, INFINITY, -INFINITY, 1.1e9f, -1.1e9f};
    tribo_force_loop_f32_config_t  loop_config = tribo_force_loop_f32_paper();
    tribo_force_loop_f32_params_t  loop;
    tribo_feedforward_f32_memory_t memory;
    loop_config.method = tribo_feedforward_f32_use(&params, &config);
    tribo_feedforward_f32_reset(&memory.state);
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&loop, &loop_config));
    for (uint32_t d = 0; d < 2u; d++)
    {
        for (int i = 0; i < 5; i++)
        {
            const tribo_feedforward_learned_t at = tribo_feedforward_f32_learned(&loop, &memory.state, d, bad[i]);
            TEST_ASSERT_FLOAT_WITHIN(1e-9f, 0.007f, at.L_n);
            TEST_ASSERT_FALSE(at.at_bound);
        }
    }
}

/// A state that is no longer a number starts anew or heals, and u goes on.
static void test_a_state_that_is_no_number_starts_anew_or_heals(void)
{
    tribo_force_loop_f32_config_t         loop_config = tribo_force_loop_f32_paper();
    static tribo_force_loop_f32_params_t  loop;
    static tribo_force_loop_f32_state_t   running;
    static tribo_feedforward_f32_memory_t memory;
    loop_config.method = tribo_feedforward_f32_use(&params, &config);
    for (size_t at = 0; at < sizeof memory.state / sizeof(float); at++)
    {
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&loop, &loop_config));
        running.memory = &memory.state.tick;
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_start(&running, &loop, false));
        float y = 0.3f;
        for (int k = 0; k < 4000; k++)
        {
            const float r = 0.3f + (k < 2000 ? 1e-5f * (float)k : 0.04f - 1e-5f * (float)k);
            if (k == 1500)
            {
                const float nothing = NAN;
                memcpy((char *)&memory.state + at * sizeof(float), &nothing, sizeof nothing);
            }
            const float u = tribo_force_loop_f32_step(&loop, &running, r, y, NULL);
            (void)tribo_feedforward_f32_learn(&loop, &memory);
            TEST_ASSERT_TRUE(fabsf(u) <= 2.0f);
            y += 0.05f * (r - y);
        }
        const tribo_feedforward_f32_state_t *const s = &memory.state;
        TEST_ASSERT_TRUE(isfinite(s->tick.e_n) && isfinite(s->f) && isfinite(s->tick.term_n) && isfinite(s->b));
        TEST_ASSERT_TRUE(isfinite(s->weights.sliding) && isfinite(s->weights.use[0]) && isfinite(s->learner.doubt));
        TEST_ASSERT_TRUE(isfinite(s->force) && isfinite(s->difference) && isfinite(s->v) && isfinite(s->error));
        TEST_ASSERT_TRUE(isfinite(s->r_noise) && isfinite(s->y_noise) && isfinite(s->learner.P[0]) &&
                         isfinite(s->learner.a[0]));
        TEST_ASSERT_TRUE(isfinite(s->learner.ratio) && isfinite(s->learner.effort_n) && isfinite(s->learner.played_n));
        TEST_ASSERT_TRUE(s->mode >= TRIBO_FEEDFORWARD_START && s->mode <= TRIBO_FEEDFORWARD_HOLD);
    }
}

/// A sample that is no number teaches nothing.
static void test_a_sample_that_is_no_number_teaches_nothing(void)
{
    tribo_feedforward_learner_t     learner = {.stop = {0.0f}};
    tribo_feedforward_f32_weights_t result;
    learner_sample_t                sample = {.L_n = 0.1f, .learns = true, .starts = true};
    tribo_learner_forget(&learner);
    tribo_learner_step(&params.learning, &learner, &sample, &result);
    sample.starts      = false;
    sample.travelled_n = 0.1f;
    sample.friction_n  = NAN;
    tribo_learner_step(&params.learning, &learner, &sample, &result);
    TEST_ASSERT_SAME_FLOAT(0.0f, learner.travel_n);
    sample.friction_n = 0.15f;
    tribo_learner_step(&params.learning, &learner, &sample, &result);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1e-3f, learner.travel_n); // 2 w
    TEST_ASSERT_TRUE(isfinite(result.sliding) && result.sliding != 1.0f);
}

static void test_forgetting_leaves_the_prior(void)
{
    tribo_feedforward_learner_t learner;
    memset(&learner, 0x3f, sizeof learner);
    tribo_learner_forget(&learner);
    for (uint32_t i = 0, k = 0; i < TRIBO_FEEDFORWARD_LEARNED; i++)
    {
        TEST_ASSERT_SAME_FLOAT(0.0f, learner.a[i]);
        for (uint32_t j = 0; j <= i; j++, k++)
        {
            TEST_ASSERT_SAME_FLOAT(i == j ? 1.0f : 0.0f, learner.P[k]);
        }
    }
    TEST_ASSERT_SAME_FLOAT(1.0f, learner.doubt);
    TEST_ASSERT_SAME_FLOAT(0.0f, learner.travel_n);
}

/// Half of what two slides without a sensor say, and half of the variance.
static void test_slides_are_taken_by_their_gain(void)
{
    const tribo_feedforward_learning_t *const p       = &params.learning;
    tribo_feedforward_learner_t               learner = {.stop = {0.0f}};
    tribo_learner_forget(&learner);
    tribo_learner_take(p, &learner, 1.2f, 0.01f, 0.5f, 0.0f, 0.3f);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.1f, tribo_learner_sliding(p, &learner));
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.005f, tribo_learner_load(p, &learner, 0.4f));
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.3f, learner.travel_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.5f, learner.P[0]);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.5f, learner.P[9]);
}

/// If nothing is learned between two reversals, the second takes no lack.
static void test_a_lack_is_taken_once(void)
{
    const tribo_feedforward_learning_t *const p       = &params.learning;
    tribo_feedforward_learner_t               learner = {.stop = {0.0f}};
    tribo_feedforward_f32_weights_t           result;
    for (uint8_t turns = 1; turns <= 2u; turns++)
    {
        const learner_sample_t sample = {.L_n = 0.1f, .turns = turns};
        tribo_learner_forget(&learner);
        learner.stop[0] = -1.0f;
        learner.surplus = 0.1f;
        tribo_learner_step(p, &learner, &sample, &result);
        TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.0f - 1.15f * 0.1f, result.sliding);
    }
}

#include "runners/test_feedforward_f32.inc" // main
