// Play (backlash) in fixed point; play_f32.h has the equation.
//
// All values have the same unit and are within +-2^30, so that x - below and x + above fit.

#ifndef TRIBO_GUARD_PLAY_Q31_H
#define TRIBO_GUARD_PLAY_Q31_H

#include "tribo/force_loop_q31.h"

#include "../number/first_order_q31.h"

#define PLAY_Q31_MAX (INT32_C(1) << 30)

/// At `position`, not yet moved: sign 0. A corrupt position counts as the nearest end of the range.
static inline void play_q31_reset(tribo_play_q31_state_t *state, int32_t position)
{
    state->position = limit_q31(position, -PLAY_Q31_MAX, PLAY_Q31_MAX);
    state->sign     = 0;
}

/// One sample of the input `x`, with the stops `below` and `above` it, 0 or more. Returns the move of the position.
static inline int32_t play_q31_step(tribo_play_q31_state_t *state, int32_t x, int32_t below, int32_t above)
{
    const int32_t before = state->position;
    const int32_t lower  = x - below;
    const int32_t upper  = x + above;
    if (before < lower)
    {
        state->position = lower;
        state->sign     = 1;
    }
    else if (before > upper)
    {
        state->position = upper;
        state->sign     = -1;
    }
    return state->position - before;
}

#endif
