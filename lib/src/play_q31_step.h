// One sample of the play, for inputs that are known to be good.

#ifndef TRIBO_PLAY_Q31_STEP_H
#define TRIBO_PLAY_Q31_STEP_H

#include "tribo/play_q31.h"

static inline int32_t play_q31_step(tribo_play_q31_state_t *state, int32_t x, int32_t below, int32_t above)
{
    const int32_t before = state->position;
    const int32_t lower  = x - below;
    const int32_t upper  = x + above;
    if (before < lower)
    {
        state->position = lower;
        state->way      = 1;
    }
    else if (before > upper)
    {
        state->position = upper;
        state->way      = -1;
    }
    return state->position - before;
}

#endif
