/// Play (backlash) in fixed point: the twin of play_f32.h.
///
/// Values may be in any one unit; they are within +-2^30, so that x - below and x + above fit.
/// No loops, no divisions. Not synchronized: one state, one tick.

#ifndef TRIBO_PLAY_Q31_H
#define TRIBO_PLAY_Q31_H

#include "tribo/q31.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct
{
    int32_t position;
    int32_t way; ///< sign of the last move, 0 before the first
} tribo_play_q31_state_t;

/// Standing at `position`, which has not moved yet.
void tribo_play_q31_reset(tribo_play_q31_state_t *state, int32_t position);

/// Takes the input `x` and returns by how much the position has moved. `below` and `above` are the distances of the stops from
/// the input. Cannot fail: x beyond +-2^30, or a distance beyond 0 to 2^30, counts as the nearest that is not.
int32_t tribo_play_q31_step(tribo_play_q31_state_t *state, int32_t x, int32_t below, int32_t above);

#ifdef __cplusplus
}
#endif

#endif
