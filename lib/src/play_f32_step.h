// One sample of the play, for inputs that are known to be good.

#ifndef TRIBO_PLAY_F32_STEP_H
#define TRIBO_PLAY_F32_STEP_H

#include "tribo/play_f32.h"

static inline float play_f32_step(tribo_play_f32_state_t *state, float x, float below, float above)
{
    const float before = state->position_n;
    const float lower  = x - below;
    const float upper  = x + above;
    if (before < lower)
    {
        state->position_n = lower;
        state->way        = 1;
    }
    else if (before > upper)
    {
        state->position_n = upper;
        state->way        = -1;
    }
    return state->position_n - before;
}

#endif
