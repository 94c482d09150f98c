// One tick of the compensator, Fig. 11, at a net force that is known to be good. F^ always is: the arm sees to that.

#ifndef TRIBO_COMPENSATOR_F32_STEP_H
#define TRIBO_COMPENSATOR_F32_STEP_H

#include "tribo/compensator_f32.h"

#include "arm_f32_step.h"
#include "friction_f32_step.h"

/// n = u - F^ + g, with F^ from the start of the tick.
static inline float compensator_f32_net_force(const tribo_compensator_f32_params_t *params,
                                              const tribo_compensator_f32_state_t  *state,
                                              float                                 u_n)
{
    return u_n - state->arm.force_n + params->friction.gravity_n;
}

/// f^, with the arm moved on to the next tick.
static inline float compensator_f32_step(const tribo_compensator_f32_params_t *params,
                                         tribo_compensator_f32_state_t        *state,
                                         float                                 n_n,
                                         tribo_compensator_f32_signals_t      *signals)
{
    const float F    = state->arm.force_n;
    signals->force_n = F; // stored early, to shorten its life
    const float f    = friction_f32_step(&params->friction, &state->friction, n_n, F, &signals->friction);
    // n - f is u + g - F^ - f^, and exactly 0 while the arm sticks.
    arm_f32_step(&params->arm, &state->arm, n_n - f);
    return f;
}

#endif
