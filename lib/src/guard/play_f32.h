// Play (backlash), single precision: a position that a moving input drags along between two stops.
//
//     position = min(x + above, max(x - below, position))
//
//     position  ----x-----------.
//                  |<-below->|  |      x may move by below + above before the position follows
//
// It detects a reversal without a derivative: `sign` changes once x has returned by below + above.
// No loops, no divisions. Not synchronized: one state, one tick.
// Source: Krasnosel'skii & Pokrovskii, "Systems with Hysteresis", ch. 2.

#ifndef TRIBO_GUARD_PLAY_F32_H
#define TRIBO_GUARD_PLAY_F32_H

#include "tribo/force_loop_f32.h"

/// At `position_n`, not yet moved: sign 0.
static inline void play_f32_reset(tribo_play_f32_state_t *state, float position_n)
{
    state->position_n = position_n;
    state->sign       = 0;
}

/// One sample of the input `x`, with the stops `below` and `above` it, 0 or more. Returns the move of the position.
static inline float play_f32_step(tribo_play_f32_state_t *state, float x, float below, float above)
{
    const float before = state->position_n;
    const float lower  = x - below;
    const float upper  = x + above;
    if (before < lower)
    {
        state->position_n = lower;
        state->sign       = 1;
    }
    else if (before > upper)
    {
        state->position_n = upper;
        state->sign       = -1;
    }
    return state->position_n - before;
}

#endif
