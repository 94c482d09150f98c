#include "tribo/compensator_lugre_f32.h"

#include "arm_f32_step.h"

void tribo_compensator_lugre_f32_reset(tribo_compensator_f32_state_t *state)
{
    tribo_lugre_f32_reset(&state->friction.lugre);
    tribo_arm_f32_reset(&state->arm);
}

float tribo_compensator_lugre_f32_step(const tribo_compensator_f32_params_t *params,
                                       const tribo_lugre_f32_params_t       *lugre,
                                       tribo_compensator_f32_state_t        *state,
                                       float                                 u_n,
                                       tribo_compensator_f32_signals_t      *signals)
{
    if (exceeds(state->arm.force_n, TRIBO_F32_FORCE_MAX_N)) // corrupt, as no step leaves it so
    {
        tribo_arm_f32_reset(&state->arm);
    }
    const float F    = state->arm.force_n;
    signals->force_n = F;
    const float f = tribo_lugre_f32_step(lugre, &params->friction, &state->friction.lugre, u_n, F, &signals->friction);
    arm_f32_step(&params->arm, &state->arm, signals->friction.n_n - f);
    return f;
}
