#include "tribo/compensator_lugre_q31.h"

#include "arm_q31_step.h"

void tribo_compensator_lugre_q31_reset(tribo_compensator_q31_state_t *state)
{
    tribo_lugre_q31_reset(&state->friction.lugre);
    tribo_arm_q31_reset(&state->arm);
}

int32_t tribo_compensator_lugre_q31_step(const tribo_compensator_q31_params_t *params,
                                         const tribo_lugre_q31_params_t       *lugre,
                                         tribo_compensator_q31_state_t        *state,
                                         int32_t                               u,
                                         tribo_compensator_q31_signals_t      *signals)
{
    const int32_t F = tribo_arm_q31_force(&state->arm);
    signals->force  = F;
    const int32_t f = tribo_lugre_q31_step(lugre, &params->friction, &state->friction.lugre, u, F, &signals->friction);
    // The drive d = n - f^. While the arm slides back the two differ in sign, and d may be beyond full scale.
    arm_q31_step(&params->arm,
                 &state->arm,
                 tribo_q31_subtract(signals->friction.n, f, &state->friction.lugre.saturated));
    return f;
}
