#include "tribo/friction_meter_q31.h"

#include "friction_meter_q31_step.h"
#include "tribo/quantize_feedforward_q31.h"
#include "units_q31.h"

#include "limit_q31.h"
#include <stddef.h>

#define FORCE_MAX (INT32_C(1) << 29)

tribo_status_t tribo_friction_meter_q31_init(tribo_friction_meter_q31_params_t *params,
                                             const tribo_path_f32_config_t     *path,
                                             float                              filter_time_s,
                                             float                              sample_time_s)
{
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_friction_meter_f32_params_t f32;
    const tribo_status_t              status = tribo_friction_meter_f32_init(&f32, path, filter_time_s, sample_time_s);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!(f32.damping < 32768.0f))
    {
        return TRIBO_ERR_DAMPING;
    }
    if (!(f32.filter_part >= UNITS_Q31_PART_MIN))
    {
        return TRIBO_ERR_SLIDE_FILTER;
    }
    uint32_t shift = 0;
    while (scaled(f32.damping, -(int32_t)shift) >= 1.0f)
    {
        shift++;
    }
    params->actuator_part = fixed_unsigned(f32.actuator_part, 32);
    params->sensor_part   = fixed_unsigned(f32.sensor_part, 32);
    params->filter_part   = fixed_unsigned(f32.filter_part, 32);
    params->damping       = fixed_unsigned(f32.damping, 32 - (int32_t)shift);
    params->change_max    = INT32_C(1) << (30u - shift);
    params->damping_shift = (uint8_t)shift;
    return TRIBO_OK;
}

void tribo_friction_meter_q31_reset(tribo_friction_meter_q31_state_t *state, int32_t force)
{
    const int32_t at  = limit_q31(force, -FORCE_MAX, FORCE_MAX);
    state->actuator   = at;
    state->sensor     = at;
    state->force      = at;
    state->difference = 0;
}

void tribo_friction_meter_q31_step(const tribo_friction_meter_q31_params_t *params,
                                   tribo_friction_meter_q31_state_t        *state,
                                   int32_t                                  u,
                                   int32_t                                  y,
                                   tribo_friction_meter_q31_signals_t      *signals)
{
    friction_meter_q31_step(params,
                            state,
                            limit_q31(u, -FORCE_MAX, FORCE_MAX),
                            limit_q31(y, -FORCE_MAX, FORCE_MAX),
                            signals);
}
