#include "friction_observer_q31.h"

#include "tribo/feedforward_f32.h"
#include "tribo/feedforward_q31.h"

#include "../number/first_order_q31.h"
#include "../number/fixed_q31.h"
#include "friction_observer_f32.h"

#include <stddef.h>

#define FORCE_MAX (INT32_C(1) << 29)

tribo_status_t tribo_friction_observer_q31_init(tribo_friction_observer_q31_params_t     *params,
                                                const tribo_reference_model_f32_config_t *reference_model,
                                                float                                     filter_time_s,
                                                float                                     sample_time_s)
{
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_friction_observer_f32_params_t f32;
    const tribo_status_t status = tribo_friction_observer_f32_init(&f32, reference_model, filter_time_s, sample_time_s);
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

void tribo_friction_observer_q31_reset(tribo_friction_observer_q31_state_t *state, int32_t force)
{
    const int32_t at  = limit_q31(force, -FORCE_MAX, FORCE_MAX);
    state->actuator   = at;
    state->sensor     = at;
    state->force      = at;
    state->difference = 0;
}
