#include "tribo/friction_meter_f32.h"

#include "friction_meter_f32_step.h"

#include <stddef.h>

tribo_status_t tribo_friction_meter_f32_init(tribo_friction_meter_f32_params_t *params,
                                             const tribo_path_f32_config_t     *path,
                                             float                              filter_time_s,
                                             float                              sample_time_s)
{
    tribo_path_f32_params_t same;
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    const tribo_status_t status = tribo_path_f32_init(&same, path, sample_time_s);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!within(filter_time_s, 1.0e-6f, 10.0f))
    {
        return TRIBO_ERR_SLIDE_FILTER;
    }
    params->actuator_part = same.actuator_part;
    params->sensor_part   = same.sensor_part;
    params->filter_part   = first_order_f32_lag(filter_time_s, sample_time_s);
    params->damping       = path->arm.damping / path->arm.stiffness / sample_time_s;
    return TRIBO_OK;
}

void tribo_friction_meter_f32_reset(tribo_friction_meter_f32_state_t *state, float force_n)
{
    *state = (tribo_friction_meter_f32_state_t){.y_n = exceeds(force_n, TRIBO_F32_FORCE_MAX_N) ? 0.0f : force_n};
}

void tribo_friction_meter_f32_step(const tribo_friction_meter_f32_params_t *params,
                                   tribo_friction_meter_f32_state_t        *state,
                                   float                                    u_n,
                                   float                                    y_n,
                                   tribo_friction_meter_f32_signals_t      *signals)
{
    if (exceeds(u_n, TRIBO_F32_FORCE_MAX_N) || exceeds(y_n, TRIBO_F32_FORCE_MAX_N))
    {
        *signals = (tribo_friction_meter_f32_signals_t){.friction_n = state->difference_n,
                                                        .force_n    = state->y_n + state->behind_n};
        return;
    }
    friction_meter_f32_step(params, state, u_n, y_n, signals);
}
