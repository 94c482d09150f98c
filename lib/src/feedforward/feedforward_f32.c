#include "tribo/feedforward_f32.h"

#include "../number/parameters.h"
#include "feedforward_f32.h"

tribo_feedforward_f32_config_t tribo_feedforward_f32_default(void)
{
    const tribo_feedforward_f32_config_t standard = {TRIBO_FEEDFORWARD_PARAMETERS(PARAMETERS_DEFAULT).learning =
                                                         tribo_breakaway_learning_f32_default(),
                                                     .hold = tribo_hold_f32_default()};
    return standard;
}

tribo_status_t tribo_feedforward_f32_init(tribo_feedforward_f32_params_t       *params,
                                          const tribo_feedforward_f32_config_t *config,
                                          const tribo_compensator_f32_config_t *model,
                                          float                                 input_max_n,
                                          float                                 sample_time_s)
{
    if (params == NULL || config == NULL || model == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    const tribo_reference_model_f32_config_t reference_model = {.actuator_pole_rad_per_s =
                                                                    config->actuator_pole_rad_per_s,
                                                                .sensor_pole_rad_per_s = config->sensor_pole_rad_per_s,
                                                                .arm                   = model->arm};

    tribo_feedforward_f32_params_t made   = {.input_max_n = input_max_n};
    tribo_status_t                 status = PARAMETERS_CHECK(tribo_feedforward_parameters, config);
    if (status == TRIBO_OK)
    {
        status = tribo_reference_model_f32_init(&made.reference_model, &reference_model, sample_time_s);
    }
    if (status == TRIBO_OK)
    {
        status = tribo_friction_observer_f32_init(&made.observer,
                                                  &reference_model,
                                                  config->slide_filter_time_s,
                                                  sample_time_s);
    }
    if (status == TRIBO_OK)
    {
        status = tribo_breakaway_learning_f32_init(&made.learning, &config->learning);
    }
    if (status == TRIBO_OK)
    {
        status = tribo_hold_f32_init(&made.hold, &config->hold, sample_time_s);
    }
    if (status == TRIBO_OK && !within(input_max_n, FLT_MIN, TRIBO_F32_FORCE_MAX_N))
    {
        status = TRIBO_ERR_INPUT_MAX;
    }
    if (status != TRIBO_OK)
    {
        return status;
    }
    const float lag =
        1.0f / reference_model.actuator_pole_rad_per_s + reference_model.arm.damping / reference_model.arm.stiffness;
    made.offset_max_n       = 4.0f * input_max_n;
    made.reversal_n         = config->reversal_n;
    made.jump               = limit_f32(2.0f * sample_time_s / config->jump_time_s, 0.0f, 2.0f);
    made.lead_s             = config->lead * lag;
    made.noise_gain         = config->noise_gain;
    made.noise_part         = limit_f32(sample_time_s / config->noise_time_s, 0.0f, 1.0f);
    made.noise_floor_n      = 0.002f * config->reversal_n;
    made.rate_hz            = 1.0f / sample_time_s;
    made.rate_part          = first_order_f32_lag(config->rate_time_s, sample_time_s);
    made.step_n             = config->rate_max_n_per_s * sample_time_s;
    made.offset_part        = limit_f32(sample_time_s / config->offset_time_s, 0.0f, 1.0f);
    made.slide_half_n       = 0.5f * config->slide_width_n;
    made.slide_change_max_n = config->slide_rate_max_n_per_s * sample_time_s;
    made.slide_run_in_n     = config->slide_run_in_n;
    made.slide_error_max_n  = config->slide_error_max_n;
    *params                 = made;
    return TRIBO_OK;
}

void tribo_feedforward_f32_reset(const tribo_feedforward_f32_params_t *params, tribo_feedforward_f32_state_t *state)
{
    state->r_n[0] = 0.0f;
    tribo_friction_observer_f32_reset(&state->observer, 0.0f);
    state->fade       = 1.0f;
    state->bad_inputs = 0;
    tribo_breakaway_learning_f32_reset(&params->learning, &state->learning);
    state->side = 1.0f;
    hold_f32_reset(&state->hold);
    tribo_feedforward_f32_restart(state);
}

void tribo_feedforward_f32_restart(tribo_feedforward_f32_state_t *state)
{
    state->running  = false;
    state->entering = false;
    state->entry_n  = 0.0f;
}

void tribo_feedforward_f32_enter(tribo_feedforward_f32_state_t *state, float added_n)
{
    state->running  = false;
    state->entering = true;
    state->entry_n  = exceeds(added_n, TRIBO_F32_FORCE_MAX_N) ? 0.0f : added_n;
}

float tribo_feedforward_f32_before(const tribo_feedforward_f32_params_t *params,
                                   const tribo_friction_f32_params_t    *friction,
                                   tribo_feedforward_f32_state_t        *state,
                                   float                                 r_n,
                                   float                                 y_n,
                                   tribo_feedforward_f32_signals_t      *signals)
{
    return feedforward_f32_before(params, friction, state, r_n, y_n, signals);
}

float tribo_feedforward_f32_added(const tribo_feedforward_f32_params_t *params,
                                  tribo_feedforward_f32_state_t        *state,
                                  float                                 v_n,
                                  tribo_feedforward_f32_signals_t      *signals)
{
    return feedforward_f32_added(params, state, exceeds(v_n, FLT_MAX) ? 0.0f : v_n, signals);
}

void tribo_feedforward_f32_after(const tribo_feedforward_f32_params_t *params,
                                 const tribo_friction_f32_params_t    *friction,
                                 tribo_feedforward_f32_state_t        *state,
                                 float                                 v_n,
                                 float                                 u_n,
                                 bool                                  limited,
                                 tribo_feedforward_f32_signals_t      *signals)
{
    if (exceeds(u_n, TRIBO_F32_FORCE_MAX_N) || exceeds(v_n, FLT_MAX))
    {
        signals->travel_n = 0.0f;
        signals->observer = (tribo_friction_observer_f32_signals_t){.friction_n = 0.0f};
        return;
    }
    feedforward_f32_after(params, friction, state, v_n, u_n, limited, signals);
}

tribo_feedforward_f32_learned_t tribo_feedforward_f32_learned(const tribo_feedforward_f32_params_t *params,
                                                              const tribo_friction_f32_params_t    *friction,
                                                              const tribo_feedforward_f32_state_t  *state,
                                                              uint32_t                              direction,
                                                              float                                 force_n)
{
    const float    force = exceeds(force_n, TRIBO_F32_FORCE_MAX_N) ? 0.0f : force_n;
    const uint32_t side  = direction & 1u;
    const float    prior = feedforward_f32_prior(friction, side, force);

    tribo_breakaway_learning_f32_state_t learning = state->learning;
    if (force * state->side < 0.0f)
    {
        tribo_breakaway_learning_f32_change_side(&params->learning, &learning); // as r would when it crosses 0
    }
    const tribo_breakaway_learning_f32_signals_t known =
        tribo_breakaway_learning_f32_at(&params->learning, &learning, side, prior);
    return (tribo_feedforward_f32_learned_t){
        .L_n               = known.L_n,
        .relative_variance = known.relative_variance,
        .travel_n          = learning.travel_n[side] + learning.across.travel_n[side],
        .at_bound          = tribo_breakaway_learning_f32_is_at_bound(&params->learning, &learning, side, prior),
        .stays_at_bound    = state->learning.stays_at_bound[side] != 0};
}
