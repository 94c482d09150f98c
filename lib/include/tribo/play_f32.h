/// Play (backlash), single precision: a position that a moving input drags along between two stops.
///
///     position = min(x + above, max(x - below, position))
///
///     position  ----x-----------.
///                  |<-below->|  |      x may move by below + above before the position follows
///
/// A reversal is seen without a derivative: `way` changes when x has come back by the width of the play. With the same width
/// on both sides it is the reversal detector of a reference, and the detector of travel of a noisy force.
/// No loops, no divisions. Not synchronized: one state, one tick.
/// Source: Krasnosel'skii & Pokrovskii, "Systems with Hysteresis", ch. 2.

#ifndef TRIBO_PLAY_F32_H
#define TRIBO_PLAY_F32_H

#include "tribo/force_f32.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct
{
    float   position_n;
    int32_t way; ///< sign of the last move, 0 before the first
} tribo_play_f32_state_t;

/// Standing at `position_n`, which has not moved yet.
void tribo_play_f32_reset(tribo_play_f32_state_t *state, float position_n);

/// Takes the input `x_n`, in N, and returns by how much the position has moved. `below_n` and `above_n`, 0 or more, are the
/// distances of the stops from the input. Cannot fail: with a NaN, or a force beyond TRIBO_F32_FORCE_MAX_N, nothing moves.
float tribo_play_f32_step(tribo_play_f32_state_t *state, float x_n, float below_n, float above_n);

#ifdef __cplusplus
}
#endif

#endif
