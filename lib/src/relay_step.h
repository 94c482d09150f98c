// One sample of the relays (Fig. 12) and of the edge detectors in front of them (Fig. 13). They decide when friction shows
// hysteresis: Q2 is armed when n comes back from deep on the negative side, Q1 from the positive one. Logic only, no numbers: a
// signal is one bit, so both relays are computed in the same words.

#ifndef TRIBO_RELAY_STEP_H
#define TRIBO_RELAY_STEP_H

#include "tribo/relay.h"

/// pulse[k] = x[k] and not x[k - W], for eight lines at once, one a bit. The ring of 64 holds the last 63 samples.
static inline uint32_t edge_step(tribo_edge_state_t *state, uint32_t width, uint32_t inputs)
{
    // The masks wrap the ring, and keep both indices inside it even if the state is corrupt.
    const uint32_t head = state->head & TRIBO_EDGE_WIDTH_MAX;
    state->line[head]   = (uint8_t)inputs;
    const uint32_t past = state->line[(head - width) & TRIBO_EDGE_WIDTH_MAX];
    state->head         = (uint8_t)(head + 1u);
    return inputs & ~past;
}

/// A relay samples its set pulse at the rising edge of its trigger, (set pulse or reset pulse), and holds it until the next
/// one: a set alone gives 1, a reset alone 0. Relay 1 is bit 0 and relay 2 is bit 1 of every word here; `held` keeps the
/// outputs in its lower half and the last triggers, from bit 4, in its upper half.
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

/// Edge detectors, then relays: the outputs Q1 and Q2 for the events of one sample.
static inline uint32_t relay_step(tribo_relay_state_t *state, uint32_t width, uint32_t events)
{
    return relay_latch_step(&state->latch, edge_step(&state->edge, width, events));
}

/// The comparators in front of the relays, Fig. 12, from comparisons of magnitudes. All arguments are 0 or 1:
///
///     negative, was_negative    n < 0, n[k-1] < 0
///     inside                    |n| < c1 L, L on the side of n
///     deep                      |n[k-1]| > c2 L, L on the side of n[k-1]
///     back                      n has moved towards the other side since n[k-1]
static inline uint32_t relay_events(uint32_t negative,
                                    uint32_t was_negative,
                                    uint32_t inside,
                                    uint32_t deep,
                                    uint32_t back)
{
    // set2 = n > -c1 L- is true for every n >= 0, and for n < 0 while it is inside; set1 is its mirror image.
    const uint32_t set = (TRIBO_RELAY_SET2 - negative) | inside * (TRIBO_RELAY_SET1 | TRIBO_RELAY_SET2);
    // Reset looks at n[k-1], so that one large step from above L2 to below it still counts as a crossing (Fig. 5).
    const uint32_t reset = (deep & back) * (TRIBO_RELAY_SET2 - was_negative) * TRIBO_RELAY_RESET1;
    return set | reset;
}

/// Eq. (8): Q = v > 0 and ((n > 0 and Q2) or (n < 0 and Q1)), 0 or 1. `rises` is v > 0; it implies n != 0.
static inline uint32_t relay_q(uint32_t relays, uint32_t negative, uint32_t rises)
{
    return (relays << negative) / TRIBO_RELAY_Q2 & rises;
}

/// The state that a step of the relays changes, for a step that is to be undone. The delay line is not part of it: with `head`
/// restored the next step overwrites the entry.
typedef struct
{
    tribo_relay_latch_t latch;
    uint8_t             head;
} relay_snapshot_t;

static inline relay_snapshot_t relay_snapshot(const tribo_relay_state_t *state)
{
    return (relay_snapshot_t){.latch = state->latch, .head = state->edge.head};
}

static inline void relay_restore(tribo_relay_state_t *state, relay_snapshot_t snapshot)
{
    state->latch     = snapshot.latch;
    state->edge.head = snapshot.head;
}

#endif
