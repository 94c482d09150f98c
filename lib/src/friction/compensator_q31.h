// Friction compensator of Fig. 11 in Q31; compensator_f32.h has the drawing. F^ comes from the arm model, never from the
// force sensor. All forces are Q31 of one full scale; only the arm's own F has more bits (Q59).
// Not synchronized: one state, one tick.

#ifndef TRIBO_FRICTION_COMPENSATOR_Q31_H
#define TRIBO_FRICTION_COMPENSATOR_Q31_H

#include "tribo/friction_q31.h"

#include "arm_q31.h"
#include "law_q31.h"

#include <stddef.h>

/// The same with a friction model other than the paper's.
int32_t tribo_compensator_q31_model_step(const tribo_compensator_q31_params_t *params,
                                         tribo_compensator_q31_state_t        *state,
                                         int32_t                               u,
                                         tribo_compensator_q31_signals_t      *signals);

/// f^ for this tick; the arm advances to the next.
static inline int32_t compensator_q31_step(const tribo_compensator_q31_params_t *params,
                                           tribo_compensator_q31_state_t        *state,
                                           int32_t                               u,
                                           tribo_compensator_q31_signals_t      *signals)
{
    if (params->model != NULL)
    {
        return tribo_compensator_q31_model_step(params, state, u, signals);
    }
    const int32_t F = tribo_arm_q31_force(&state->arm);
    signals->force  = F;
    const int32_t n = friction_q31_net_force(&params->friction, &state->friction.paper, u, F);
    const int32_t f = friction_q31_step(&params->friction, &state->friction.paper, n, F, &signals->friction);
    // The drive d = u + g - F^ - f^ cannot overflow: |f^| <= |n|, with the same sign. Below breakaway f^ = n, so d is
    // exactly 0 and the arm sticks.
    arm_q31_step(&params->arm, &state->arm, n - f);
    return f;
}

static inline bool compensator_q31_same_model(const tribo_compensator_q31_params_t *a,
                                              const tribo_compensator_q31_params_t *b)
{
    return a->model == b->model || (a->model != NULL && b->model != NULL && a->model->step == b->model->step);
}

/// The f^ that `params` would give for `u` in this tick; nothing advances.
int32_t tribo_compensator_q31_peek(const tribo_compensator_q31_params_t *params,
                                   tribo_compensator_q31_state_t        *state,
                                   int32_t                               u);

/// Starts with an arm at rest at `force` under `u`. Returns f^, which holds it there as far as L allows.
int32_t tribo_compensator_q31_enter(const tribo_compensator_q31_params_t *params,
                                    tribo_compensator_q31_state_t        *state,
                                    int32_t                               u,
                                    int32_t                               force);

#endif
