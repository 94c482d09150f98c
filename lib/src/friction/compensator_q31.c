#include "compensator_q31.h"

#include "tribo/friction_f32.h"

#include <stddef.h>

tribo_status_t tribo_compensator_q31_init(tribo_compensator_q31_params_t       *params,
                                          tribo_breakaway_point_q31_t          *table,
                                          const tribo_compensator_f32_config_t *config,
                                          float                                 sample_time_s,
                                          float                                 full_scale_n)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    // Check the arm first, because the init of the friction writes the table once it has accepted the config.
    tribo_compensator_q31_params_t made;
    tribo_compensator_f32_params_t f32;
    tribo_status_t                 status = tribo_compensator_f32_init(&f32, config, sample_time_s);
    status = status != TRIBO_OK ? status : tribo_arm_q31_init(&made.arm, &config->arm, sample_time_s);
    status = status != TRIBO_OK
                 ? status
                 : tribo_friction_q31_init(&made.friction, table, &config->friction, sample_time_s, full_scale_n);
    if (status == TRIBO_OK)
    {
        *params = made;
    }
    return status;
}

void tribo_compensator_q31_reset(tribo_compensator_q31_state_t *state)
{
    tribo_friction_q31_reset(&state->friction);
    tribo_arm_q31_reset(&state->arm);
}

int32_t tribo_compensator_q31_step(const tribo_compensator_q31_params_t *params,
                                   tribo_compensator_q31_state_t        *state,
                                   int32_t                               u,
                                   tribo_compensator_q31_signals_t      *signals)
{
    return compensator_tick(params, state, u, signals);
}
