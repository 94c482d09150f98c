#include "compensator_f32.h"

#include "tribo/friction_f32.h"

#include <stddef.h>

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
    status = status == TRIBO_OK ? tribo_arm_f32_init(&made.arm, &config->arm, sample_time_s) : status;
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
    if (exceeds(state->arm.force_n, TRIBO_F32_FORCE_MAX_N)) // the state is corrupt: no step leaves such a value
    {
        tribo_arm_f32_reset(&state->arm);
    }
    const float F = state->arm.force_n;
    float       n = friction_f32_net_force(&params->friction, &state->friction, u_n, F);
    if (exceeds(u_n, TRIBO_F32_FORCE_MAX_N))
    {
        n = state->friction.n_n;
        count(&state->friction.bad_inputs);
    }
    return compensator_advance(params, state, n, F, signals);
}
