#include "tribo/path_f32.h"

#include "path_f32_step.h"

#include <stddef.h>

tribo_path_f32_config_t tribo_path_f32_paper(void)
{
    const tribo_path_f32_config_t paper = {.actuator_pole_rad_per_s = 200.0f,
                                           .sensor_pole_rad_per_s   = 55.0f,
                                           .arm                     = tribo_arm_f32_paper()};
    return paper;
}

tribo_status_t tribo_path_f32_init(tribo_path_f32_params_t       *params,
                                   const tribo_path_f32_config_t *config,
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
    const float actuator = config->actuator_pole_rad_per_s * sample_time_s;
    const float sensor   = config->sensor_pole_rad_per_s * sample_time_s;
    if (!within(actuator, 1.0e-9f, 50.0f))
    {
        return TRIBO_ERR_ACTUATOR_POLE;
    }
    if (!within(sensor, 1.0e-9f, 50.0f))
    {
        return TRIBO_ERR_SENSOR_POLE;
    }
    tribo_path_f32_params_t made   = {.actuator_part = first_order_f32_part(actuator),
                                      .sensor_part   = first_order_f32_part(sensor)};
    const tribo_status_t    status = tribo_arm_f32_init(&made.arm, &config->arm, sample_time_s);
    if (status == TRIBO_OK)
    {
        *params = made;
    }
    return status;
}

void tribo_path_f32_reset(tribo_path_f32_state_t *state)
{
    tribo_arm_f32_reset(&state->arm);
    state->actuator_n = 0.0f;
    state->sensor_n   = 0.0f;
}

float tribo_path_f32_step(const tribo_path_f32_params_t *params,
                          tribo_path_f32_state_t        *state,
                          float                          moved_n,
                          float                          ahead_n)
{
    const float moved = exceeds(moved_n, 2.0f * TRIBO_F32_FORCE_MAX_N) ? 0.0f : moved_n;
    const float ahead = exceeds(ahead_n, 2.0f * TRIBO_F32_FORCE_MAX_N) ? 0.0f : ahead_n;
    return path_f32_step(params, state, moved, ahead);
}
