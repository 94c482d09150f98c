/// Edge detectors of Fig. 13, eight side by side, one a bit:
///
///     pulse[k] = x[k] and not x[k - W]
///
/// A rising edge gives a pulse of W samples. An input that toggles faster than W gives what the
/// circuit gives: each high sample is compared with the one W samples ago, not with the last one.
/// No loops in a step. Not synchronized: one state, one tick. Reset a state before its first step: zeroing is not enough.

#ifndef TRIBO_EDGE_H
#define TRIBO_EDGE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TRIBO_EDGE_WIDTH_MAX 63u ///< longest pulse, in samples

typedef struct
{
    uint8_t line[TRIBO_EDGE_WIDTH_MAX + 1u]; ///< past inputs, a ring
    uint8_t head;                            ///< where the next input goes
} tribo_edge_state_t;

/// Fills the delay lines with `rest`: bit i is the level at which input i is said to have rested.
void tribo_edge_reset(tribo_edge_state_t *state, uint8_t rest);

/// Takes the inputs of one sample (bit i is input i) and returns the pulses. `width` is W,
/// 1 to TRIBO_EDGE_WIDTH_MAX samples; only its low six bits are used and 0 gives no pulse.
/// W may change between samples; the past is kept. Cannot fail.
uint8_t tribo_edge_step(tribo_edge_state_t *state, uint8_t width, uint8_t inputs);

#ifdef __cplusplus
}
#endif

#endif
