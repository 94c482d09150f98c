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
    return compensator_q31_kernel(params, state, u, signals, true);
}
