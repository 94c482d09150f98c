#include "tribo/hold_q31.h"

#include "hold_q31_step.h"
#include "tribo/quantize_feedforward_q31.h"
#include "units_q31.h"

#include <stddef.h>

#define FORCE_MAX (INT32_C(1) << 29)

static int32_t within_range(int32_t x)
{
    return limit_q31(x, -FORCE_MAX, FORCE_MAX);
}

static uint32_t breakaway(uint32_t L)
{
    return L < (uint32_t)FORCE_MAX ? L : (uint32_t)FORCE_MAX;
}

tribo_status_t tribo_hold_q31_init(tribo_hold_q31_params_t       *params,
                                   const tribo_hold_f32_config_t *config,
                                   float                          sample_time_s,
                                   float                          full_scale_n)
{
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_hold_f32_params_t f32;
    const tribo_status_t    status = tribo_hold_f32_init(&f32, config, sample_time_s);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!full_scale_ok(full_scale_n))
    {
        return TRIBO_ERR_FULL_SCALE;
    }
    // 2^16 units or more, so that their inverse fits.
    if (!within(config->caution_travel_n / full_scale_n, 1.25e-4f, 1.0e3f))
    {
        return TRIBO_ERR_HOLD_CAUTION;
    }
    if (!(f32.deadband_part >= UNITS_Q31_PART_MIN))
    {
        return TRIBO_ERR_HOLD_DEADBAND;
    }
    params->on               = f32.on;
    params->still_ticks      = f32.still_ticks;
    params->quick_ticks      = f32.quick_ticks;
    params->gain             = fixed_unsigned(f32.gain, 32);
    params->margin           = fixed_unsigned(f32.margin, 32);
    params->caution_per_unit = fixed_unsigned(f32.caution_per_n * full_scale_n, 48 - 29);
    params->deadband_part    = fixed_unsigned(f32.deadband_part, 32);
    return TRIBO_OK;
}

void tribo_hold_q31_reset(tribo_hold_q31_state_t *state, int32_t force)
{
    *state = (tribo_hold_q31_state_t){.anchor = within_range(force)};
}

bool tribo_hold_q31_stands(const tribo_hold_q31_params_t *params,
                           tribo_hold_q31_state_t        *state,
                           int32_t                        reference,
                           uint32_t                       half,
                           bool                           step)
{
    return hold_q31_stands(params, state, within_range(reference), half, step);
}

void tribo_hold_q31_enter(tribo_hold_q31_state_t *state, int32_t u, int32_t f, int32_t way, int32_t y)
{
    hold_q31_enter(state, within_range(u), within_range(f), way, within_range(y));
}

int32_t tribo_hold_q31_step(const tribo_hold_q31_params_t *params,
                            tribo_hold_q31_state_t        *state,
                            int32_t                        u,
                            uint32_t                       positive,
                            uint32_t                       negative)
{
    return hold_q31_step(params, state, within_range(u), breakaway(positive), breakaway(negative));
}

int32_t tribo_hold_q31_deadband(const tribo_hold_q31_params_t *params,
                                tribo_hold_q31_state_t        *state,
                                int32_t                        e,
                                int32_t                        y)
{
    return hold_q31_deadband(params, state, within_range(e), within_range(y));
}

void tribo_hold_q31_learned(const tribo_hold_q31_params_t *params, tribo_hold_q31_state_t *state, uint32_t travel)
{
    const uint32_t most = UINT32_C(1) << 20;
    hold_q31_learned(params, state, travel < most ? travel : most);
}
