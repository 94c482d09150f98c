// One sample of the relays (Fig. 12) and of the edge detectors in front of them (Fig. 13).

#ifndef TRIBO_RELAY_STEP_H
#define TRIBO_RELAY_STEP_H

#include "tribo/relay.h"

/// pulse[k] = x[k] and not x[k - W], eight lines at once, one a bit.
static inline uint32_t edge_step(tribo_edge_state_t *state, uint32_t width, uint32_t inputs)
{
    // The masks keep both indices inside the line even if the state has been overwritten.
    const uint32_t head = state->head & TRIBO_EDGE_WIDTH_MAX;
    state->line[head]   = (uint8_t)inputs;
    const uint32_t past = state->line[(head - width) & TRIBO_EDGE_WIDTH_MAX];
    state->head         = (uint8_t)(head + 1u);
    return inputs & ~past;
}

/// A relay's output is its set pulse, sampled and held at the rising edge of (set pulse or reset pulse). Relay 1 lives in
/// bit 0 and relay 2 in bit 1 of every word here.
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

static inline uint32_t relay_step(tribo_relay_state_t *state, uint32_t width, uint32_t events)
{
    return relay_latch_step(&state->latch, edge_step(&state->edge, width, events));
}

/// Comparators in front of the relays, Fig. 12, from what a caller knows of magnitudes; all are 0 or 1. `negative` is the
/// side of n and `was_negative` that of n[k-1], `inside` says |n| < c1 L, `deep` |n[k-1]| > c2 L, each L on its own side.
/// `back` says that n has moved towards the other side.
static inline uint32_t relay_events(uint32_t negative,
                                    uint32_t was_negative,
                                    uint32_t inside,
                                    uint32_t deep,
                                    uint32_t back)
{
    // The set line of the side where n is not rests high; that of its own side is high inside. Relay 1 is one bit below
    // relay 2.
    const uint32_t set = TRIBO_RELAY_SET2 >> negative | inside * (TRIBO_RELAY_SET1 | TRIBO_RELAY_SET2);
    // Reset looks at n[k-1], so that one large step from above L2 to below it still counts as a crossing (Fig. 5).
    const uint32_t reset = (deep & back) * (TRIBO_RELAY_RESET2 >> was_negative);
    return set | reset;
}

/// Eq. (8), 0 or 1: |n| rises, and the relay that is armed on the other side is high. `rises` is 0 or 1; at n = 0 nothing
/// can have risen.
static inline uint32_t relay_q(uint32_t relays, uint32_t negative, uint32_t rises)
{
    return (relays << negative) / TRIBO_RELAY_Q2 & rises;
}

/// What a step of the relays overwrites, to undo it. Its inputs may stay in the delay line: the next step puts its own
/// there.
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
