// Friction compensator of Fig. 11, single precision. One step:
//
//     1. F^ = K theta^, the force of the arm model, never the noisy sensor
//     2. f^ = friction(u, F^)
//     3. the arm model advances one sample with u and f^ held
//
// The caller adds gain * f^ to u at the next tick. Not synchronized: one state, one tick.
//
// One tick of the compensator, Fig. 11:
//
//     u ---> n = u - F^ + g ---> friction ---> f^ ---> the loop adds gain f^ to u at the next tick
//            ^                      |
//            '---- F^ <--- arm <----' d = n - f^
//
// F^ comes from the arm model, never from the force sensor: noise there would look like a reversal of n. The caller has
// checked u; the arm keeps F^ within TRIBO_F32_FORCE_MAX_N.

#ifndef TRIBO_FRICTION_COMPENSATOR_F32_H
#define TRIBO_FRICTION_COMPENSATOR_F32_H

#include "tribo/friction_f32.h"

#include "arm_f32.h"
#include "law_f32.h"

#include <stddef.h>

/// Net force n = u - F^ + g, with F^ from the start of the tick.
static inline float compensator_f32_net_force(const tribo_compensator_f32_params_t *params,
                                              const tribo_compensator_f32_state_t  *state,
                                              float                                 u_n)
{
    return u_n - state->arm.force_n + params->friction.gravity_n;
}

/// The same with a friction model other than the paper's.
float tribo_compensator_f32_model_step(const tribo_compensator_f32_params_t *params,
                                       tribo_compensator_f32_state_t        *state,
                                       float                                 n_n,
                                       tribo_compensator_f32_signals_t      *signals);

/// f^ for this tick; the arm advances to the next.
static inline float compensator_f32_step(const tribo_compensator_f32_params_t *params,
                                         tribo_compensator_f32_state_t        *state,
                                         float                                 n_n,
                                         tribo_compensator_f32_signals_t      *signals)
{
    if (params->model != NULL)
    {
        return tribo_compensator_f32_model_step(params, state, n_n, signals);
    }
    const float F    = state->arm.force_n;
    signals->force_n = F;
    const float f    = friction_f32_step(&params->friction, &state->friction.paper, n_n, F, &signals->friction);
    // The drive d = u + g - F^ - f^. Below breakaway f^ = n, so it is exactly 0 and the arm sticks.
    arm_f32_step(&params->arm, &state->arm, n_n - f);
    return f;
}

static inline bool compensator_f32_same_model(const tribo_compensator_f32_params_t *a,
                                              const tribo_compensator_f32_params_t *b)
{
    return a->model == b->model || (a->model != NULL && b->model != NULL && a->model->step == b->model->step);
}

/// The f^ that `params` would give for `u_n` in this tick; nothing advances.
float tribo_compensator_f32_peek(const tribo_compensator_f32_params_t *params,
                                 tribo_compensator_f32_state_t        *state,
                                 float                                 u_n);

/// Starts with an arm at rest at `force_n` under `u_n`. Returns f^, which holds it there as far as L allows.
float tribo_compensator_f32_enter(const tribo_compensator_f32_params_t *params,
                                  tribo_compensator_f32_state_t        *state,
                                  float                                 u_n,
                                  float                                 force_n);

#endif
