#include "tribo/compensator_q31.h"

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
    const int32_t f     = tribo_friction_q31_step(&params->friction, &state->friction, u, force, &signals->friction);
    signals->force      = force;

    // n - f is u + g - F^ - f^, no larger than n, and exactly 0 while the arm sticks.
    (void)tribo_arm_q31_step(&params->arm, &state->arm, signals->friction.n - f);
    return f;
}
