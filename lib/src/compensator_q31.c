#include "tribo/compensator_q31.h"

#include "compensator_q31_kernel.h"

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
    const int32_t force = tribo_arm_q31_force(&state->arm);
    signals->force      = force;
    const int32_t f     = tribo_friction_q31_step(&params->friction, &state->friction, u, force, &signals->friction);
    arm_q31_kernel(&params->arm, &state->arm, state->friction.n - f);
    return f;
}
