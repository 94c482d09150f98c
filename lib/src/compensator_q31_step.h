// One tick of the compensator, Fig. 11, in Q31; compensator_f32_step.h has the drawing. F^ comes from the arm model, never from
// the force sensor. All forces are Q31 of one full scale; only the arm's own F has more bits (Q59).

#ifndef TRIBO_COMPENSATOR_Q31_STEP_H
#define TRIBO_COMPENSATOR_Q31_STEP_H

#include "tribo/compensator_q31.h"

#include "arm_q31_step.h"
#include "friction_q31_step.h"

/// f^ for this tick; the arm advances to the next.
static inline int32_t compensator_q31_step(const tribo_compensator_q31_params_t *params,
                                           tribo_compensator_q31_state_t        *state,
                                           int32_t                               u,
                                           tribo_compensator_q31_signals_t      *signals)
{
    const int32_t F = tribo_arm_q31_force(&state->arm);
    signals->force  = F;
    const int32_t n = friction_q31_net_force(&params->friction, &state->friction.paper, u, F);
    const int32_t f = friction_q31_step(&params->friction, &state->friction.paper, n, F, &signals->friction);
    // The drive d = u + g - F^ - f^. As |f^| <= |n| and both have one sign, it cannot overflow; below breakaway f^ = n, so
    // it is exactly 0 and the arm sticks.
    arm_q31_step(&params->arm, &state->arm, n - f);
    return f;
}

#endif
