#include "reference_model_q31.h"

#include "tribo/feedforward_f32.h"
#include "tribo/feedforward_q31.h"

#include "../number/fixed_q31.h"
#include "reference_model_f32.h"

#include <stddef.h>

tribo_status_t tribo_reference_model_q31_init(tribo_reference_model_q31_params_t       *params,
                                              const tribo_reference_model_f32_config_t *config,
                                              float                                     sample_time_s)
{
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_reference_model_f32_params_t f32;
    tribo_status_t                     status = tribo_reference_model_f32_init(&f32, config, sample_time_s);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!(f32.actuator_part >= UNITS_Q31_PART_MIN))
    {
        return TRIBO_ERR_ACTUATOR_POLE;
    }
    if (!(f32.sensor_part >= UNITS_Q31_PART_MIN))
    {
        return TRIBO_ERR_SENSOR_POLE;
    }
    tribo_reference_model_q31_params_t made = {.actuator_part = fixed_unsigned(f32.actuator_part, 32),
                                               .sensor_part   = fixed_unsigned(f32.sensor_part, 32)};
    status                                  = tribo_arm_q31_init(&made.arm, &config->arm, sample_time_s);
    if (status == TRIBO_OK)
    {
        *params = made;
    }
    return status;
}

void tribo_reference_model_q31_reset(tribo_reference_model_q31_state_t *state)
{
    tribo_arm_q31_reset(&state->arm);
    state->actuator  = 0;
    state->sensor    = 0;
    state->saturated = 0;
}
