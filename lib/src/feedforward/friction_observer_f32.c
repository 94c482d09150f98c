#include "friction_observer_f32.h"

#include "tribo/feedforward_f32.h"

#include "../number/parameters.h"

#include <stddef.h>

static bool filter_time_ok(float slide_filter_time_s)
{
    return TRIBO_SLIDE_FILTER_PARAMETER(PARAMETERS_WITHIN);
}

tribo_status_t tribo_friction_observer_f32_init(tribo_friction_observer_f32_params_t     *params,
                                                const tribo_reference_model_f32_config_t *reference_model,
                                                float                                     filter_time_s,
                                                float                                     sample_time_s)
{
    tribo_reference_model_f32_params_t same;
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    const tribo_status_t status = tribo_reference_model_f32_init(&same, reference_model, sample_time_s);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!filter_time_ok(filter_time_s))
    {
        return TRIBO_ERR_SLIDE_FILTER;
    }
    params->actuator_part = same.actuator_part;
    params->sensor_part   = same.sensor_part;
    params->filter_part   = first_order_f32_lag(filter_time_s, sample_time_s);
    params->damping       = reference_model->arm.damping / reference_model->arm.stiffness / sample_time_s;
    return TRIBO_OK;
}

void tribo_friction_observer_f32_reset(tribo_friction_observer_f32_state_t *state, float force_n)
{
    *state = (tribo_friction_observer_f32_state_t){.y_n = exceeds(force_n, TRIBO_F32_FORCE_MAX_N) ? 0.0f : force_n};
}
