// One tick of the compensator, Fig. 11.

#ifndef TRIBO_COMPENSATOR_Q31_STEP_H
#define TRIBO_COMPENSATOR_Q31_STEP_H

#include "tribo/compensator_q31.h"

#include "arm_q31_step.h"
#include "friction_q31_step.h"

/// f^, with the arm moved on to the next tick.
static inline int32_t compensator_q31_step(const tribo_compensator_q31_params_t *params,
                                           tribo_compensator_q31_state_t        *state,
                                           int32_t                               u,
                                           tribo_compensator_q31_signals_t      *signals)
{
    const int32_t F = tribo_arm_q31_force(&state->arm);
    signals->force  = F; // stored early, to shorten its life
    const int32_t n = friction_q31_net_force(&params->friction, &state->friction, u, F);
    const int32_t f = friction_q31_step(&params->friction, &state->friction, n, F, &signals->friction);
    // n - f is u + g - F^ - f^, no larger than n, and exactly 0 while the arm sticks.
    arm_q31_step(&params->arm, &state->arm, n - f);
    return f;
}

#endif
