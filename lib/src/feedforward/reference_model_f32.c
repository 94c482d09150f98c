#include "reference_model_f32.h"

#include "tribo/feedforward_f32.h"

#include "../number/parameters.h"

#include <stddef.h>

tribo_reference_model_f32_config_t tribo_reference_model_f32_paper(void)
{
    const tribo_feedforward_f32_config_t standard = tribo_feedforward_f32_default();

    const tribo_reference_model_f32_config_t paper = {.actuator_pole_rad_per_s = standard.actuator_pole_rad_per_s,
                                                      .sensor_pole_rad_per_s   = standard.sensor_pole_rad_per_s,
                                                      .arm                     = tribo_arm_f32_paper()};
    return paper;
}

tribo_status_t tribo_reference_model_f32_init(tribo_reference_model_f32_params_t       *params,
                                              const tribo_reference_model_f32_config_t *config,
                                              float                                     sample_time_s)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    if (!sample_time_ok(sample_time_s))
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
    tribo_reference_model_f32_params_t made   = {.actuator_part = first_order_f32_part(actuator),
                                                 .sensor_part   = first_order_f32_part(sensor)};
    const tribo_status_t               status = tribo_arm_f32_init(&made.arm, &config->arm, sample_time_s);
    if (status == TRIBO_OK)
    {
        *params = made;
    }
    return status;
}

void tribo_reference_model_f32_reset(tribo_reference_model_f32_state_t *state)
{
    tribo_arm_f32_reset(&state->arm);
    state->actuator_n = 0.0f;
    state->sensor_n   = 0.0f;
}
