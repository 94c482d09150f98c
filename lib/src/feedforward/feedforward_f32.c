#include "tribo/feedforward_f32.h"

#include "../number/ranges.h"
#include "learner.h"
#include "words_f32.h"

#include "reference.h"

#define ROW(...) PARAMETERS_ROW(tribo_feedforward_f32_config_t, __VA_ARGS__)
const tribo_parameter_t tribo_feedforward_parameters[] = {TRIBO_FEEDFORWARD_PARAMETERS(ROW)};
#undef ROW

#define REVERSAL   (1.0f / 314.0f) // default w, in B
#define PRESLIDING (1.0f / 11.0f)  // default d, in B
#define STOP_RATIO 0.375f          // d_1 in d
#define JUMP_LAG   1.5f            // time by which z lags behind the stops, in T_j
#define FORGETTING 0.0157f         // default Q, in 1/B
#define SLOW_S     0.3f            // time constant of the means of noise and error; faster changes of side are chatter
#define SLOW_TICKS 100.0f          // least time constant of the mean of noise
#define FAST       0.8f            // T_y in tau: the time constant of rate, v and y
#define FAST_TICKS 5.0f            // least T_y
#define STEP       4000.0f         // a rate of r from which on it counts as a step, in B/314 per second
#define LEAK       1000.0f         // time constant in which b fades, in tau
#define SAMPLE     10.0f           // ticks between two samples of the learner
#define OFFSET_MAX 4.0f            // limit of |b|, in input_max

static float or_derived(float given, float derived)
{
    return given > 0.0f ? given : derived;
}

/// A time in ticks, at least 1.
static uint32_t ticks(float time_s, float sample_time_s)
{
    const uint32_t nearest = (uint32_t)(time_s / sample_time_s + 0.5f);
    return nearest > 0u ? nearest : 1u;
}

tribo_feedforward_f32_config_t tribo_feedforward_f32_default(void)
{
    const tribo_feedforward_f32_config_t standard = {TRIBO_FEEDFORWARD_PARAMETERS(PARAMETERS_DEFAULT)};
    return standard;
}

static tribo_status_t check(const tribo_feedforward_f32_config_t *config,
                            float                                 input_max_n,
                            float                                 usual_force_n,
                            float                                 h)
{
    const tribo_status_t status = PARAMETERS_CHECK(tribo_feedforward_parameters, config);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!sample_time_ok(h))
    {
        return TRIBO_ERR_SAMPLE_TIME;
    }
    if (!(config->actuator_pole_rad_per_s * h <= 50.0f)) // the ranges of both hold it above 1e-9
    {
        return TRIBO_ERR_ACTUATOR_POLE;
    }
    if (!(config->sensor_pole_rad_per_s * h <= 50.0f)) // the ranges of both hold it above 1e-9
    {
        return TRIBO_ERR_SENSOR_POLE;
    }
    if (config->reversal_n > 0.0f && config->reversal_n < 1.0e-9f)
    {
        return TRIBO_ERR_REVERSAL_WIDTH;
    }
    if (config->presliding_n > 0.0f && config->presliding_n < 1.0e-9f)
    {
        return TRIBO_ERR_PRESLIDING;
    }
    if (!within(usual_force_n, 0.0f, TRIBO_F32_FORCE_MAX_N))
    {
        return TRIBO_ERR_USUAL_FORCE;
    }
    return within(input_max_n, FLT_MIN, TRIBO_F32_FORCE_MAX_N) ? TRIBO_OK : TRIBO_ERR_INPUT_MAX;
}

/// Sets the constants of the tick, with tau = `lag`.
static void set_reference(tribo_feedforward_f32_params_t       *made,
                          const tribo_feedforward_f32_config_t *config,
                          float                                 B,
                          float                                 lag,
                          float                                 h)
{
    const float jump_s  = or_derived(config->jump_time_s, TRIBO_FEEDFORWARD_JUMP_TIME * lag);
    made->reversal      = or_derived(config->reversal_n, REVERSAL * B);
    made->jump          = limit_f32(2.0f * h / jump_s, 0.0f, 2.0f);
    made->lead_gain     = config->jump_lead / (config->actuator_pole_rad_per_s * h);
    made->lag_gain      = lag / h;
    made->step          = STEP * REVERSAL * B * h;
    made->noise_floor   = 0.002f * made->reversal;
    made->noise_part    = first_order_f32_lag(larger(SLOW_S, SLOW_TICKS * h), h);
    made->slow_part     = first_order_f32_lag(SLOW_S, h);
    made->fast_part     = first_order_f32_lag(larger(FAST * lag, FAST_TICKS * h), h);
    made->lag_part      = first_order_f32_lag(lag, h);
    made->actuator_part = first_order_f32_part(config->actuator_pole_rad_per_s * h);
    made->sensor_part   = first_order_f32_part(config->sensor_pole_rad_per_s * h);
    made->leak_part     = first_order_f32_lag(LEAK * lag, SAMPLE * h);
    made->trust         = config->trust;
    made->still_ticks   = config->still_time_s > 0.0f ? ticks(config->still_time_s, h) : 0u;
    made->quick_ticks   = ticks(SLOW_S, h);

    made->learning.reversal_n = made->reversal;
    made->learning.jump_lag   = JUMP_LAG * jump_s / (SAMPLE * h);
}

/// Adds numbers to a checksum: products by words as in FNV-1a, with a shift that brings the high bits down. -0 is 0.
static uint32_t mixed(uint32_t sum, const float *numbers, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
    {
        sum = (sum ^ bits_f32(numbers[i] + 0.0f)) * 16777619u;
        sum ^= sum >> 15;
    }
    return sum;
}

/// Checksum of the numbers that learned values refer to: breakaway, gravity and presliding as configured. The laws and
/// the points of a table are arrays of floats.
static uint32_t rig_of(const tribo_friction_f32_params_t *friction, const tribo_feedforward_f32_config_t *config)
{
    const uint32_t each = sizeof(tribo_breakaway_point_f32_t) / sizeof(float);
    const uint32_t both = 2u * sizeof(tribo_breakaway_f32_t) / sizeof(float);
    const uint32_t rig  = mixed(mixed(1u, &config->presliding_n, 1), &friction->gravity_n, 1);
    return mixed(mixed(rig, (const float *)friction->law, both),
                 (const float *)friction->table,
                 friction->table_length * each);
}

/// Sets the stops and the constants of the learner. The deviations S say how wrong a configured breakaway and load
/// usually are.
static void set_learning(tribo_feedforward_f32_params_t *made, const tribo_feedforward_f32_config_t *config, float B)
{
    tribo_feedforward_learning_t *const learning = &made->learning;

    const float d      = or_derived(config->presliding_n, PRESLIDING * B);
    made->stop_gain[0] = 1.0f / (STOP_RATIO * d);
    made->stop_gain[1] = 1.0f / d;

    learning->breakaway_n      = B;
    learning->per_n[0]         = 2.0f / made->reversal;
    learning->per_n[1]         = made->stop_gain[0];
    learning->per_n[2]         = made->stop_gain[1];
    learning->deviation[0]     = 0.4f;
    learning->deviation[1]     = 0.55f;
    learning->deviation[2]     = 0.55f;
    learning->deviation[3]     = 0.3f * B;
    learning->deviation[4]     = 0.1f;
    learning->forgetting_per_n = or_derived(config->forgetting_per_n, FORGETTING / B);
    learning->trust            = config->trust;
    learning->unit_n           = 1.0f;
}

tribo_status_t tribo_feedforward_f32_init(tribo_feedforward_f32_params_t       *params,
                                          const tribo_feedforward_f32_config_t *config,
                                          const tribo_arm_f32_config_t         *arm,
                                          const tribo_friction_f32_params_t    *friction,
                                          float                                 input_max_n,
                                          float                                 usual_force_n,
                                          float                                 sample_time_s)
{
    if (params == NULL || config == NULL || arm == NULL || friction == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    const tribo_status_t status = check(config, input_max_n, usual_force_n, sample_time_s);
    if (status != TRIBO_OK)
    {
        return status;
    }
    const prior_t usual = prior_of(friction, usual_force_n);
    const float   lag   = tribo_feedforward_f32_lag_s(config, arm);
    *params             = (tribo_feedforward_f32_params_t){.input_max    = input_max_n,
                                                           .offset_max   = OFFSET_MAX * input_max_n,
                                                           .damping_gain = arm->damping / arm->stiffness / sample_time_s};
    set_reference(params, config, usual.L, lag, sample_time_s);
    set_learning(params, config, usual.L);
    params->learning.rig = rig_of(friction, config);
    return TRIBO_OK;
}

static tribo_status_t init_for(params_t                             *params,
                               const tribo_feedforward_f32_config_t *config,
                               const tribo_force_loop_f32_config_t  *loop,
                               float                                 full_scale_n,
                               const loop_params_t                  *made)
{
    (void)full_scale_n;
    return tribo_feedforward_f32_init(params,
                                      config,
                                      &loop->compensator.arm,
                                      &made->compensator.friction,
                                      loop->input_max_n,
                                      tribo_force_loop_f32_usual_force_n(loop),
                                      loop->sample_time_s);
}

#include "make.h"
