#include "tribo/path_q31.h"

#include "path_q31_step.h"
#include "tribo/quantize_feedforward_q31.h"
#include "tribo/quantize_q31.h"
#include "units_q31.h"

#include <stddef.h>

tribo_status_t tribo_path_q31_init(tribo_path_q31_params_t       *params,
                                   const tribo_path_f32_config_t *config,
                                   float                          sample_time_s)
{
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_path_f32_params_t f32;
    tribo_status_t          status = tribo_path_f32_init(&f32, config, sample_time_s);
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
    tribo_path_q31_params_t made = {.actuator_part = fixed_unsigned(f32.actuator_part, 32),
                                    .sensor_part   = fixed_unsigned(f32.sensor_part, 32)};
    status                       = tribo_arm_q31_init(&made.arm, &config->arm, sample_time_s);
    if (status == TRIBO_OK)
    {
        *params = made;
    }
    return status;
}

void tribo_path_q31_reset(tribo_path_q31_state_t *state)
{
    tribo_arm_q31_reset(&state->arm);
    state->actuator  = 0;
    state->sensor    = 0;
    state->saturated = 0;
}

int32_t tribo_path_q31_step(const tribo_path_q31_params_t *params,
                            tribo_path_q31_state_t        *state,
                            int32_t                        moved,
                            int32_t                        ahead)
{
    return path_q31_step(params, state, moved, ahead);
}
