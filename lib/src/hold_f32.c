#include "tribo/hold_f32.h"

#include "hold_f32_step.h"

#include <stddef.h>

tribo_hold_f32_config_t tribo_hold_f32_default(void)
{
    const tribo_hold_f32_config_t standard = {.gain             = 0.95f,
                                              .still_time_s     = 1.5f,
                                              .margin           = 0.85f,
                                              .quick_time_s     = 0.2f,
                                              .caution_travel_n = 0.1f,
                                              .deadband_time_s  = 0.3f};
    return standard;
}

static tribo_status_t check(const tribo_hold_f32_config_t *config)
{
    if (!within(config->gain, 0.0f, 0.99f))
    {
        return TRIBO_ERR_HOLD_GAIN;
    }
    if (!within(config->still_time_s, 1.0e-6f, 1.0e3f) || !within(config->quick_time_s, 1.0e-6f, 1.0e3f))
    {
        return TRIBO_ERR_HOLD_TIME;
    }
    if (!within(config->margin, 0.1f, 1.0f))
    {
        return TRIBO_ERR_HOLD_MARGIN;
    }
    if (!within(config->caution_travel_n, 1.0e-9f, TRIBO_F32_FORCE_MAX_N))
    {
        return TRIBO_ERR_HOLD_CAUTION;
    }
    if (!within(config->deadband_time_s, 1.0e-6f, 1.0e3f))
    {
        return TRIBO_ERR_HOLD_DEADBAND;
    }
    return TRIBO_OK;
}

tribo_status_t tribo_hold_f32_init(tribo_hold_f32_params_t       *params,
                                   const tribo_hold_f32_config_t *config,
                                   float                          sample_time_s)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    if (!within(sample_time_s, 1.0e-6f, 0.1f))
    {
        return TRIBO_ERR_SAMPLE_TIME;
    }
    const tribo_status_t status = check(config);
    if (status != TRIBO_OK)
    {
        return status;
    }
    params->on            = config->gain > 0.0f;
    params->still_ticks   = (uint32_t)(config->still_time_s / sample_time_s + 0.5f) + 1u;
    params->quick_ticks   = (uint32_t)(config->quick_time_s / sample_time_s + 0.5f) + 1u;
    params->gain          = config->gain;
    params->margin        = config->margin;
    params->caution_per_n = 1.0f / config->caution_travel_n;
    params->deadband_part = first_order_f32_lag(config->deadband_time_s, sample_time_s);
    return TRIBO_OK;
}

void tribo_hold_f32_reset(tribo_hold_f32_state_t *state, float force_n)
{
    *state = (tribo_hold_f32_state_t){.anchor_n = exceeds(force_n, TRIBO_F32_FORCE_MAX_N) ? 0.0f : force_n};
}

bool tribo_hold_f32_stands(const tribo_hold_f32_params_t *params,
                           tribo_hold_f32_state_t        *state,
                           float                          reference_n,
                           float                          half_n,
                           bool                           step)
{
    if (exceeds(reference_n, TRIBO_F32_FORCE_MAX_N) || exceeds(half_n, TRIBO_F32_FORCE_MAX_N))
    {
        state->still = 0;
        return false;
    }
    return hold_f32_stands(params, state, reference_n, half_n, step);
}

void tribo_hold_f32_enter(tribo_hold_f32_state_t *state, float u_n, float f_n, int32_t way, float y_n)
{
    hold_f32_enter(state,
                   exceeds(u_n, TRIBO_F32_FORCE_MAX_N) ? 0.0f : u_n,
                   exceeds(f_n, TRIBO_F32_FORCE_MAX_N) ? 0.0f : f_n,
                   way,
                   exceeds(y_n, TRIBO_F32_FORCE_MAX_N) ? 0.0f : y_n);
}

float tribo_hold_f32_step(const tribo_hold_f32_params_t *params,
                          tribo_hold_f32_state_t        *state,
                          float                          u_n,
                          float                          positive_n,
                          float                          negative_n)
{
    const bool good = !exceeds(u_n, TRIBO_F32_FORCE_MAX_N) && within(positive_n, 0.0f, TRIBO_F32_FORCE_MAX_N) &&
                      within(negative_n, 0.0f, TRIBO_F32_FORCE_MAX_N);
    return good ? hold_f32_step(params, state, u_n, positive_n, negative_n) : 0.0f;
}

float tribo_hold_f32_deadband(const tribo_hold_f32_params_t *params,
                              tribo_hold_f32_state_t        *state,
                              float                          e_n,
                              float                          y_n)
{
    const bool bad = exceeds(e_n, TRIBO_F32_FORCE_MAX_N) || exceeds(y_n, TRIBO_F32_FORCE_MAX_N);
    return bad ? e_n : hold_f32_deadband(params, state, e_n, y_n);
}

void tribo_hold_f32_learned(const tribo_hold_f32_params_t *params, tribo_hold_f32_state_t *state, float travel_n)
{
    if (within(travel_n, 0.0f, TRIBO_F32_FORCE_MAX_N))
    {
        hold_f32_learned(params, state, travel_n);
    }
}
