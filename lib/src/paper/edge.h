// Edge detectors of Fig. 13, eight side by side, one a bit:
//
//     pulse[k] = x[k] and not x[k - W]
//
// A rising edge gives a pulse of W samples. An input that toggles faster than W is handled like in the circuit: each high sample
// is compared with the one W samples ago, not with the last one.
// No loops in a step. Not synchronized: one state, one tick. Reset a state before its first step: zeroing is not enough.

#ifndef TRIBO_PAPER_EDGE_H
#define TRIBO_PAPER_EDGE_H

#include "tribo/friction_f32.h"

/// Fills the delay lines with `rest`: bit i is the level at which input i has rested for ever.
static inline void edge_reset(tribo_edge_state_t *state, uint8_t rest)
{
    for (uint32_t i = 0; i <= TRIBO_EDGE_WIDTH_MAX; i++)
    {
        state->line[i] = rest;
    }
    state->head = 0;
}

/// The pulses for the inputs of one sample, bit i for input i. `width` is W, 1 to TRIBO_EDGE_WIDTH_MAX: only its low six bits
/// count, and 0 gives no pulse. W may change between samples; the past is kept. The ring of 64 holds the last 63 samples.
static inline uint32_t edge_step(tribo_edge_state_t *state, uint32_t width, uint32_t inputs)
{
    // The masks wrap the ring, and keep both indices inside it even if the state is corrupt.
    const uint32_t head = state->head & TRIBO_EDGE_WIDTH_MAX;
    state->line[head]   = (uint8_t)inputs;
    const uint32_t past = state->line[(head - width) & TRIBO_EDGE_WIDTH_MAX];
    state->head         = (uint8_t)(head + 1u);
    return inputs & ~past;
}

#endif
