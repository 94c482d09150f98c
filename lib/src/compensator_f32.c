#include "tribo/compensator_f32.h"

#include "compensator_f32_kernel.h"

#include <stddef.h>

tribo_compensator_f32_config_t tribo_compensator_f32_paper(void)
{
    const tribo_compensator_f32_config_t paper = {.friction = tribo_friction_f32_paper(), .arm = tribo_arm_f32_paper()};
    return paper;
}

tribo_status_t tribo_compensator_f32_init(tribo_compensator_f32_params_t       *params,
                                          const tribo_compensator_f32_config_t *config,
                                          float                                 sample_time_s)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_compensator_f32_params_t made;
    tribo_status_t                 status = tribo_friction_f32_init(&made.friction, &config->friction, sample_time_s);
    if (status == TRIBO_OK)
    {
        status = tribo_arm_f32_init(&made.arm, &config->arm, sample_time_s);
    }
    if (status == TRIBO_OK)
    {
        *params = made;
    }
    return status;
}

void tribo_compensator_f32_reset(tribo_compensator_f32_state_t *state)
{
    tribo_friction_f32_reset(&state->friction);
    tribo_arm_f32_reset(&state->arm);
}

float tribo_compensator_f32_step(const tribo_compensator_f32_params_t *params,
                                 tribo_compensator_f32_state_t        *state,
                                 float                                 u_n,
                                 tribo_compensator_f32_signals_t      *signals)
{
    const float force_n = state->arm.force_n;
    signals->force_n    = force_n;
    const float f = tribo_friction_f32_step(&params->friction, &state->friction, u_n, force_n, &signals->friction);
    (void)arm_f32_kernel(&params->arm, &state->arm, state->friction.n_n - f);
    return f;
}
