#include "tribo/feedforward_f32.h"

#include "../number/first_order_f32.h"
#include "../number/ranges.h"
#include "bank_f32.h"
#include "constants.h"
#include "feedback.h"
#include "learning_f32.h"

#include <stddef.h>

#define ROW(...) PARAMETERS_ROW(tribo_feedforward_f32_config_t, __VA_ARGS__)
const tribo_parameter_t tribo_feedforward_parameters[] = {TRIBO_FEEDFORWARD_PARAMETERS(ROW)};
#undef ROW

/// B.
static float breakaway_of(const tribo_friction_f32_params_t *friction, float usual_force_n)
{
    return bank_f32_prior(friction, usual_force_n).L_n;
}

/// tau.
static float lag_of(float actuator_pole_rad_per_s, const tribo_arm_f32_config_t *arm)
{
    return 1.0f / actuator_pole_rad_per_s + arm->damping / arm->stiffness;
}

static float or_derived(float given, float derived)
{
    return given > 0.0f ? given : derived;
}

/// Ticks of a time, at least 1.
static uint32_t ticks(float time_s, float sample_time_s)
{
    const uint32_t nearest = (uint32_t)(time_s / sample_time_s + 0.5f);
    return nearest > 0u ? nearest : 1u;
}

/// `config` with its derived numbers.
static tribo_feedforward_f32_config_t derived(const tribo_feedforward_f32_config_t *config, float B, float lag_s)
{
    tribo_feedforward_f32_config_t made = *config;

    made.reversal_n       = or_derived(config->reversal_n, B * FEEDFORWARD_REVERSAL);
    made.presliding_n     = or_derived(config->presliding_n, B * FEEDFORWARD_PRESLIDING);
    made.jump_time_s      = or_derived(config->jump_time_s, FEEDFORWARD_JUMP_TIME * lag_s);
    made.forgetting_per_n = or_derived(config->forgetting_per_n, FEEDFORWARD_FORGETTING / B);
    return made;
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
    if (!(config->actuator_pole_rad_per_s * h <= 50.0f)) // from 1e-9, by the ranges of both
    {
        return TRIBO_ERR_ACTUATOR_POLE;
    }
    if (!(config->sensor_pole_rad_per_s * h <= 50.0f)) // from 1e-9, by the ranges of both
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

/// What follows the reference, for breakaway B and lag tau.
static void set_reference(tribo_feedforward_f32_params_t       *made,
                          const tribo_feedforward_f32_config_t *used,
                          float                                 B,
                          float                                 lag,
                          float                                 h)
{
    float d = used->presliding_n;
    for (uint32_t j = TRIBO_FEEDFORWARD_STOPS; j > 0u; j--)
    {
        made->stop_per_n[j - 1u] = 1.0f / d;
        d *= FEEDFORWARD_STOP_RATIO;
    }
    made->reversal_n    = used->reversal_n;
    made->jump          = limit_f32(2.0f * h / used->jump_time_s, 0.0f, 2.0f);
    made->lead          = used->jump_lead / (used->actuator_pole_rad_per_s * h);
    made->distrust      = 1.0f - used->trust;
    made->lag_s         = lag;
    made->noise_part    = h / larger(FEEDFORWARD_NOISE_TIME, FEEDFORWARD_NOISE_TICKS * h);
    made->noise_floor_n = FEEDFORWARD_NOISE_FLOOR * used->reversal_n;
    made->rate_hz       = 1.0f / h;
    made->rate_part     = first_order_f32_lag(larger(FEEDFORWARD_RATE_TIME * lag, FEEDFORWARD_RATE_TICKS * h), h);
    made->step_n        = B / FEEDFORWARD_STEP_TIME * h;
    made->lag_part      = first_order_f32_lag(lag, h);
    made->actuator_part = first_order_f32_part(used->actuator_pole_rad_per_s * h);
    made->sensor_part   = first_order_f32_part(used->sensor_pole_rad_per_s * h);
    made->still_ticks   = used->still_time_s > 0.0f ? ticks(used->still_time_s, h) : 0u;
    made->quick_ticks   = ticks(FEEDFORWARD_QUICK_TIME, h);
    made->deadband_part = first_order_f32_lag(FEEDFORWARD_DEADBAND_TIME, h);
}

/// What measures, learns and judges friction.
static void set_learning(tribo_feedforward_f32_params_t       *made,
                         const tribo_feedforward_f32_config_t *used,
                         float                                 B,
                         float                                 lag,
                         float                                 h)
{
    const float sample_s = (float)FEEDFORWARD_STAGES * h;
    made->observer_part =
        first_order_f32_lag(larger(FEEDFORWARD_OBSERVER_TIME * lag, FEEDFORWARD_OBSERVER_TICKS * h), h);
    made->jump_lag         = FEEDFORWARD_JUMP_LAG / sample_s;
    made->measured_per_n   = 2.0f / used->reversal_n;
    made->travel_half_n    = 0.5f * FEEDFORWARD_TRAVEL_WIDTH * used->reversal_n;
    made->slip_n           = B / FEEDFORWARD_SLIP_TIME * sample_s;
    made->travel_max_n     = B * FEEDFORWARD_TRAVEL_MAX;
    made->weighing_n       = B * FEEDFORWARD_WEIGHING;
    made->doubt_per_n      = 1.0f / (B * FEEDFORWARD_DOUBT_TRAVEL);
    made->margin_per_n     = 1.0f / (B * FEEDFORWARD_MARGIN_TRAVEL);
    made->forgetting_per_n = used->forgetting_per_n;
    made->constant_sd_n    = B * FEEDFORWARD_CONSTANT_SD;
    made->constant_max_n   = B;
    made->effort_part      = first_order_f32_lag(FEEDFORWARD_EFFORT_TIME, sample_s);
    made->effort_half_n    = 0.5f * FEEDFORWARD_EFFORT_WIDTH * B;
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
    const float                          B    = breakaway_of(friction, usual_force_n);
    const float                          lag  = lag_of(config->actuator_pole_rad_per_s, arm);
    const tribo_feedforward_f32_config_t used = derived(config, B, lag);
    tribo_feedforward_f32_params_t       made = {.input_max_n  = input_max_n,
                                                 .offset_max_n = FEEDFORWARD_OFFSET_MAX * input_max_n,
                                                 .damping      = arm->damping / arm->stiffness / sample_time_s};
    set_reference(&made, &used, B, lag, sample_time_s);
    set_learning(&made, &used, B, lag, sample_time_s);
    *params = made;
    return TRIBO_OK;
}

void tribo_feedforward_f32_reset(tribo_feedforward_f32_state_t *state)
{
    *state = (tribo_feedforward_f32_state_t){.mode = TRIBO_FEEDFORWARD_RESTART};
    learning_f32_forget(&state->learned);
}

tribo_feedforward_f32_learned_t tribo_feedforward_f32_learned(const tribo_friction_f32_params_t   *friction,
                                                              const tribo_feedforward_f32_state_t *state,
                                                              uint32_t                             direction,
                                                              float                                force_n)
{
    const tribo_feedforward_weights_f32_t *const learned = &state->learned;

    const float            force  = exceeds(force_n, TRIBO_F32_FORCE_MAX_N) ? 0.0f : force_n;
    const bank_f32_prior_t prior  = bank_f32_prior(friction, force);
    const float            sign   = (direction & 1u) == TRIBO_BREAKAWAY_POSITIVE ? 1.0f : -1.0f;
    const float            load   = sign * (prior.load_n + bank_f32_load(learned, force) + friction->gravity_n);
    const float            V      = learned->weight[0];
    const bool             inside = V > FEEDFORWARD_WEIGHT_LOW && V < FEEDFORWARD_WEIGHT_MAX;
    return (tribo_feedforward_f32_learned_t){
        .L_n               = larger(V * prior.L_n + load, FEEDFORWARD_LEARNED_MIN * V * prior.L_n),
        .relative_variance = learning_f32_relative_variance(learned, &state->learning, sign),
        .travel_n          = learned->travel_n,
        .at_bound          = !inside,
        .stays_at_bound    = tribo_feedforward_stays_at_bound(state->at_bound),
        .harms             = state->monitor.feedback.harms != 0u,
        .forgotten         = state->forgotten};
}

void tribo_feedforward_f32_restore(tribo_feedforward_f32_state_t *state)
{
    state->at_bound      = 0;
    state->monitor.ratio = 0.0f;
    feedback_restore(&state->monitor.feedback);
}

void tribo_force_loop_feedforward_f32_attach(tribo_force_loop_f32_state_t   *state,
                                             tribo_feedforward_f32_memory_t *memory)
{
    state->memory      = memory;
    state->memory_seal = ~(uintptr_t)memory;
    if (memory != NULL)
    {
        memory->signals    = (tribo_feedforward_f32_signals_t){.e_n = 0.0f};
        memory->state.mode = TRIBO_FEEDFORWARD_RESTART;
        memory->state.tick = (tribo_force_loop_f32_tick_t){.has_e = false};
        memory->motion     = (tribo_feedforward_f32_motion_t){.sign = 0};
    }
}

tribo_feedforward_f32_config_t tribo_feedforward_f32_tuned(const tribo_feedforward_f32_rig_t *rig)
{
    tribo_feedforward_f32_config_t config = tribo_feedforward_f32_default();
    config.actuator_pole_rad_per_s        = rig->actuator_pole_rad_per_s;
    config.sensor_pole_rad_per_s          = rig->sensor_pole_rad_per_s;
    return derived(&config,
                   breakaway_of(rig->friction, rig->usual_force_n),
                   lag_of(rig->actuator_pole_rad_per_s, rig->arm));
}

tribo_guard_f32_config_t tribo_guard_f32_tuned(const tribo_feedforward_f32_rig_t *rig)
{
    const float              B     = breakaway_of(rig->friction, rig->usual_force_n);
    tribo_guard_f32_config_t tuned = tribo_guard_f32_default();

    tuned.turn_n       = B / 3.14f;
    tuned.stray_n      = larger(B / 15.7f, 8.0f * rig->noise_n);
    tuned.quick_time_s = limit_f32(16.0f * lag_of(rig->actuator_pole_rad_per_s, rig->arm),
                                   20.0f * rig->sample_time_s,
                                   1.0e5f * rig->sample_time_s); // the guard's own bound
    return tuned;
}
