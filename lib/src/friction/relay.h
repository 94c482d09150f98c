// The two relays of Fig. 12, which remember the last large excursion of the net force n. They decide when friction
// shows hysteresis: Q2 is armed when n returns from large negative values, Q1 from large positive ones.
//
//     Q2 = 1       +---->----+----        Q1 = 1   ----+----<----+
//                  ^         v                         v         ^
//     Q2 = 0   ----+----<----+           Q1 = 0        +---->----+----
//                 -L1        L2                      -L2       L1   n
//
// Each output is a sample-and-hold of its set pulse, triggered by the rising edge of (set pulse or reset pulse). The
// pulses come from the edge detectors of Fig. 13. Eight detectors run in parallel, one in each bit:
//
//     pulse[k] = x[k] and not x[k - W]
//
// A rising edge gives a pulse of W samples. An input that toggles faster than W is handled as in the circuit: each high
// sample is compared with the one W samples ago, not with the last one.
//
// The caller compares numbers and passes events, so f32, Q31 and the plant share this logic. A signal is one bit, so
// both relays are computed in the same words. A step has no loops. Not synchronized: one state, one tick. Reset a state
// before its first step: zeroing it is not enough.

#ifndef TRIBO_FRICTION_RELAY_H
#define TRIBO_FRICTION_RELAY_H

#include "tribo/friction_f32.h"

/// Fills the delay lines as if the inputs had always been at `rest`, bit i for input i.
static inline void edge_reset(tribo_edge_state_t *state, uint8_t rest)
{
    for (uint32_t i = 0; i <= TRIBO_EDGE_WIDTH_MAX; i++)
    {
        state->line[i] = rest;
    }
    state->head = 0;
}

/// The pulses for the inputs of one sample, bit i for input i. `width` is W, 1 to TRIBO_EDGE_WIDTH_MAX. Only its low
/// six bits count, and 0 gives no pulse. W may change between samples, because the ring of 64 keeps the last 63
/// samples.
static inline uint32_t edge_step(tribo_edge_state_t *state, uint32_t width, uint32_t inputs)
{
    // The masks wrap the ring, and keep both indices inside it even if the state is corrupt.
    const uint32_t head = state->head & TRIBO_EDGE_WIDTH_MAX;
    state->line[head]   = (uint8_t)inputs;
    const uint32_t past = state->line[(head - width) & TRIBO_EDGE_WIDTH_MAX];
    state->head         = (uint8_t)(head + 1u);
    return inputs & ~past;
}

/// Sets the outputs low, the set lines as if they had always been high, and the reset lines low.
static inline void relay_reset(tribo_relay_state_t *state)
{
    edge_reset(&state->edge, TRIBO_RELAY_SET1 | TRIBO_RELAY_SET2);
    state->latch.held = 0;
}

/// A relay samples its set pulse at the rising edge of its trigger, (set pulse or reset pulse), and holds the sample
/// until the next edge. So a set alone gives 1 and a reset alone gives 0. Relay 1 is bit 0 and relay 2 is bit 1 of
/// every word here. The lower half of `held` keeps the outputs, the upper half the last triggers, from bit 4 on.
static inline uint32_t relay_latch_step(tribo_relay_latch_t *latch, uint32_t pulses)
{
    const uint32_t both    = TRIBO_RELAY_Q1 | TRIBO_RELAY_Q2;
    const uint32_t held    = latch->held & both;
    const uint32_t set     = pulses & (TRIBO_RELAY_SET1 | TRIBO_RELAY_SET2);
    const uint32_t reset   = pulses / TRIBO_RELAY_RESET1;
    const uint32_t trigger = set | reset;
    const uint32_t rising  = trigger & ~((uint32_t)latch->held >> 4);
    const uint32_t outputs = (set & rising) | (held & ~rising);

    latch->held = (uint8_t)(outputs | trigger << 4);
    return outputs;
}

/// The outputs TRIBO_RELAY_Q1 and _Q2 for the events of one sample (TRIBO_RELAY_SET1 ...). Edge detectors turn these
/// into pulses of `width` samples, 1 to TRIBO_EDGE_WIDTH_MAX.
static inline uint32_t relay_step(tribo_relay_state_t *state, uint32_t width, uint32_t events)
{
    return relay_latch_step(&state->latch, edge_step(&state->edge, width, events));
}

/// The comparators in front of the relays, Fig. 12, from comparisons of magnitudes. All arguments are 0 or 1:
///
///     negative, was_negative    n < 0, n[k-1] < 0
///     inside                    |n| < c1 L, L for the sign of n
///     deep                      |n[k-1]| > c2 L, L for the sign of n[k-1]
///     back                      n has moved towards the other sign since n[k-1]
static inline uint32_t relay_events(uint32_t negative,
                                    uint32_t was_negative,
                                    uint32_t inside,
                                    uint32_t deep,
                                    uint32_t back)
{
    // set2 = n > -c1 L- is true for every n >= 0, and for n < 0 while |n| is inside; set1 is its mirror image.
    const uint32_t own = negative != 0u ? TRIBO_RELAY_SET1 : TRIBO_RELAY_SET2;
    const uint32_t set = inside != 0u ? TRIBO_RELAY_SET1 | TRIBO_RELAY_SET2 : own;
    // Reset looks at n[k-1], so that one large step from above L2 to below it still counts as a crossing (Fig. 5).
    const uint32_t from  = was_negative != 0u ? TRIBO_RELAY_RESET1 : TRIBO_RELAY_RESET2;
    const uint32_t reset = (deep & back) != 0u ? from : 0u;
    return set | reset;
}

/// Eq. (8): Q = v > 0 and ((n > 0 and Q2) or (n < 0 and Q1)), 0 or 1. `rises` is v > 0, which implies n != 0.
static inline uint32_t relay_q(uint32_t relays, uint32_t negative, uint32_t rises)
{
    const uint32_t armed = relays & (negative != 0u ? TRIBO_RELAY_Q1 : TRIBO_RELAY_Q2);
    return armed != 0u && rises != 0u ? 1u : 0u;
}

#endif
