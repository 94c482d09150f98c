#include "tribo/arm_q31.h"

#include "arm_q31_kernel.h"

void tribo_arm_q31_reset(tribo_arm_q31_state_t *state)
{
    state->force        = 0;
    state->force_change = 0;
    state->saturated    = 0;
}

int32_t tribo_arm_q31_step(const tribo_arm_q31_params_t *params, tribo_arm_q31_state_t *state, int32_t drive)
{
    arm_q31_kernel(params, state, drive);
    return tribo_arm_q31_force(state);
}
