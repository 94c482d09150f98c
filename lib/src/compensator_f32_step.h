// One tick of the compensator, Fig. 11:
//
//     u ---> n = u - F^ + g ---> friction ---> f^ ---> the loop adds gain f^ to u at the next tick
//            ^                      |
//            '---- F^ <--- arm <----' d = n - f^
//
// F^ comes from the arm model, never from the force sensor: noise there would look like a reversal of n. The caller has
// checked u; the arm keeps F^ within TRIBO_F32_FORCE_MAX_N.

#ifndef TRIBO_COMPENSATOR_F32_STEP_H
#define TRIBO_COMPENSATOR_F32_STEP_H

#include "tribo/compensator_f32.h"

#include "arm_f32_step.h"
#include "friction_f32_step.h"

/// Net force n = u - F^ + g, with F^ from the start of the tick.
static inline float compensator_f32_net_force(const tribo_compensator_f32_params_t *params,
                                              const tribo_compensator_f32_state_t  *state,
                                              float                                 u_n)
{
    return u_n - state->arm.force_n + params->friction.gravity_n;
}

/// f^ for this tick; the arm advances to the next.
static inline float compensator_f32_step(const tribo_compensator_f32_params_t *params,
                                         tribo_compensator_f32_state_t        *state,
                                         float                                 n_n,
                                         tribo_compensator_f32_signals_t      *signals)
{
    const float F    = state->arm.force_n;
    signals->force_n = F;
    const float f    = friction_f32_step(&params->friction, &state->friction.paper, n_n, F, &signals->friction);
    // The drive d = u + g - F^ - f^. Below breakaway f^ = n, so it is exactly 0 and the arm sticks.
    arm_f32_step(&params->arm, &state->arm, n_n - f);
    return f;
}

#endif
