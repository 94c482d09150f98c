// One tick of the compensator with plain friction, inline.

#ifndef TRIBO_COMPENSATOR_Q31_KERNEL_H
#define TRIBO_COMPENSATOR_Q31_KERNEL_H

#include "tribo/compensator_q31.h"

#include "arm_q31_kernel.h"
#include "friction_q31_kernel.h"

static inline int32_t compensator_q31_kernel(const tribo_compensator_q31_params_t *params,
                                             tribo_compensator_q31_state_t        *state,
                                             int32_t                               u,
                                             tribo_compensator_q31_signals_t      *signals)
{
    const int32_t force = tribo_arm_q31_force(&state->arm);
    signals->force      = force;
    const int32_t n     = tribo_q31_balance(u, force, params->friction.gravity, &state->friction.saturated);
    const int32_t f     = friction_q31_kernel(&params->friction, &state->friction, n, force, &signals->friction, false);

    // n - f is u + g - F^ - f^, no larger than n, and exactly 0 while the arm sticks.
    arm_q31_kernel(&params->arm, &state->arm, n - f);
    return f;
}

#endif
