#include "tribo/feedforward_q31.h"

#include "tribo/feedforward_f32.h"

#include "../number/fixed_q31.h"
#include "../number/parameters.h"
#include "feedforward_f32.h"
#include "feedforward_q31.h"

#include <stddef.h>

/// Ranges that are narrower than in f32.
static tribo_status_t check(const tribo_feedforward_f32_params_t *f32, float full_scale_n)
{
    if (!within(f32->input_max_n / full_scale_n, FIXED_Q31_SMALLEST, 1.0f))
    {
        return TRIBO_ERR_INPUT_MAX;
    }
    if (!fits(f32->reversal_n, full_scale_n))
    {
        return TRIBO_ERR_REVERSAL_WIDTH;
    }
    if (!(f32->noise_part >= UNITS_Q31_PART_MIN))
    {
        return TRIBO_ERR_NOISE_TIME;
    }
    if (!(f32->rate_part >= UNITS_Q31_PART_MIN))
    {
        return TRIBO_ERR_RATE_TIME;
    }
    if (!within(f32->step_n / full_scale_n, FIXED_Q31_SMALLEST, 0.0078125f))
    {
        return TRIBO_ERR_RATE_MAX;
    }
    if (!(f32->lead_s * f32->rate_hz < 256.0f * 256.0f) ||
        !(f32->lead_s * f32->rate_hz * f32->step_n <= 0.5f * full_scale_n))
    {
        return TRIBO_ERR_LEAD;
    }
    if (!(f32->offset_part < 0.5f))
    {
        return TRIBO_ERR_OFFSET_TIME;
    }
    if (!fits(2.0f * f32->slide_half_n, full_scale_n))
    {
        return TRIBO_ERR_SLIDE_WIDTH;
    }
    if (!within(f32->slide_change_max_n / full_scale_n, FIXED_Q31_SMALLEST, 0.001953125f))
    {
        return TRIBO_ERR_SLIDE_RATE;
    }
    if (!fits(f32->slide_run_in_n, full_scale_n))
    {
        return TRIBO_ERR_SLIDE_RUN_IN;
    }
    if (!fits(f32->slide_error_max_n, full_scale_n))
    {
        return TRIBO_ERR_SLIDE_ERROR;
    }
    return TRIBO_OK;
}

/// Reference model, friction observer, learning and hold.
static tribo_status_t quantize_parts(tribo_feedforward_q31_params_t       *made,
                                     const tribo_feedforward_f32_config_t *config,
                                     const tribo_compensator_f32_config_t *model,
                                     float                                 sample_time_s,
                                     float                                 full_scale_n)
{
    const tribo_reference_model_f32_config_t reference_model = {.actuator_pole_rad_per_s =
                                                                    config->actuator_pole_rad_per_s,
                                                                .sensor_pole_rad_per_s = config->sensor_pole_rad_per_s,
                                                                .arm                   = model->arm};

    tribo_status_t status = tribo_reference_model_q31_init(&made->reference_model, &reference_model, sample_time_s);
    if (status == TRIBO_OK)
    {
        status = tribo_friction_observer_q31_init(&made->observer,
                                                  &reference_model,
                                                  config->slide_filter_time_s,
                                                  sample_time_s);
    }
    if (status == TRIBO_OK)
    {
        status = tribo_breakaway_learning_q31_init(&made->learning, &config->learning, full_scale_n);
    }
    return status != TRIBO_OK ? status : tribo_hold_q31_init(&made->hold, &config->hold, sample_time_s, full_scale_n);
}

tribo_status_t tribo_feedforward_q31_init(tribo_feedforward_q31_params_t       *params,
                                          const tribo_feedforward_f32_config_t *config,
                                          const tribo_compensator_f32_config_t *model,
                                          float                                 input_max_n,
                                          float                                 sample_time_s,
                                          float                                 full_scale_n)
{
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_feedforward_f32_params_t f32;
    tribo_feedforward_q31_params_t made   = {.reversal = 0};
    tribo_status_t                 status = tribo_feedforward_f32_init(&f32, config, model, input_max_n, sample_time_s);
    if (status == TRIBO_OK && !full_scale_ok(full_scale_n))
    {
        status = TRIBO_ERR_FULL_SCALE;
    }
    status = status != TRIBO_OK ? status : quantize_parts(&made, config, model, sample_time_s, full_scale_n);
    status = status != TRIBO_OK ? status : check(&f32, full_scale_n);
    if (status != TRIBO_OK)
    {
        return status;
    }
    made.input_max  = (uint32_t)fixed_force(f32.input_max_n, full_scale_n);
    made.offset_max = units(f32.offset_max_n < full_scale_n ? f32.offset_max_n : full_scale_n, full_scale_n);
    made.reversal   = (uint32_t)units(f32.reversal_n, full_scale_n);
    made.jump =
        f32.jump < 2.0f ? fixed(f32.jump, 29) + 1 : INT32_C(1) << 30; // rounded up, so that the ramp ends in time
    // In 256 ticks: the rate is 256 times finer than forces.
    const float lead = f32.lead_s * f32.rate_hz / 256.0f;
    while (scaled(lead, -(int32_t)made.lead_shift) >= 1.0f)
    {
        made.lead_shift++;
    }
    made.lead             = fixed_unsigned(lead, 32 - (int32_t)made.lead_shift);
    made.noise_gain       = fixed_unsigned(f32.noise_gain, 27);
    made.noise_part       = fixed_unsigned(f32.noise_part, 32);
    made.noise_floor      = fixed_unsigned(f32.noise_floor_n / full_scale_n, 37);
    made.rate_part        = fixed_unsigned(f32.rate_part, 32);
    made.step             = units(f32.step_n, full_scale_n);
    made.offset_part      = fixed(f32.offset_part, 32);
    made.slide_half       = units(f32.slide_half_n, full_scale_n);
    made.slide_change_max = units(f32.slide_change_max_n, full_scale_n);
    made.slide_run_in     = (uint32_t)units(f32.slide_run_in_n, full_scale_n);
    made.slide_error_max  = units(f32.slide_error_max_n, full_scale_n);
    *params               = made;
    return TRIBO_OK;
}

void tribo_feedforward_q31_reset(const tribo_feedforward_q31_params_t *params, tribo_feedforward_q31_state_t *state)
{
    state->r[0]       = 0;
    state->y          = 0;
    state->fade       = UINT32_MAX;
    state->bad_inputs = 0;
    tribo_breakaway_learning_q31_reset(&params->learning, &state->learning);
    state->side = 1;
    hold_q31_reset(&state->hold);
    tribo_feedforward_q31_restart(state);
}

void tribo_feedforward_q31_restart(tribo_feedforward_q31_state_t *state)
{
    state->running  = false;
    state->entering = false;
    state->entry    = 0;
}

void tribo_feedforward_q31_enter(tribo_feedforward_q31_state_t *state, int32_t added)
{
    state->running  = false;
    state->entering = true;
    state->entry    = added;
}

int32_t tribo_feedforward_q31_before(const tribo_feedforward_q31_params_t *params,
                                     const tribo_friction_q31_params_t    *friction,
                                     tribo_feedforward_q31_state_t        *state,
                                     int32_t                               r,
                                     int32_t                               y,
                                     tribo_feedforward_q31_signals_t      *signals)
{
    return feedforward_q31_before(params, friction, state, r, y, signals);
}

int32_t tribo_feedforward_q31_added(const tribo_feedforward_q31_params_t *params,
                                    tribo_feedforward_q31_state_t        *state,
                                    int32_t                               v,
                                    tribo_feedforward_q31_signals_t      *signals)
{
    return feedforward_q31_added(params, state, v, signals);
}

void tribo_feedforward_q31_after(const tribo_feedforward_q31_params_t *params,
                                 const tribo_friction_q31_params_t    *friction,
                                 tribo_feedforward_q31_state_t        *state,
                                 int32_t                               v,
                                 int32_t                               u,
                                 bool                                  limited,
                                 tribo_feedforward_q31_signals_t      *signals)
{
    feedforward_q31_after(params, friction, state, v, u, limited, signals);
}

tribo_feedforward_q31_learned_t tribo_feedforward_q31_learned(const tribo_feedforward_q31_params_t *params,
                                                              const tribo_friction_q31_params_t    *friction,
                                                              const tribo_feedforward_q31_state_t  *state,
                                                              uint32_t                              direction,
                                                              int32_t                               force)
{
    const uint32_t side  = direction & 1u;
    const uint32_t prior = feedforward_q31_prior(friction, side, feedforward_q31_inside(force));

    tribo_breakaway_learning_q31_state_t learning = state->learning;
    if (tribo_q31_multiply(force, state->side) < 0)
    {
        tribo_breakaway_learning_q31_change_side(&learning); // as r would when it crosses 0
    }
    const tribo_breakaway_learning_q31_signals_t known =
        tribo_breakaway_learning_q31_at(&params->learning, &learning, side, prior);
    return (tribo_feedforward_q31_learned_t){
        .L                 = known.L,
        .relative_variance = known.relative_variance,
        .travel            = learning.travel[side] + learning.across.travel[side],
        .at_bound          = tribo_breakaway_learning_q31_is_at_bound(&params->learning, &learning, side, prior),
        .stays_at_bound    = state->learning.stays_at_bound[side] != 0};
}
