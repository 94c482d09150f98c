// One sample of the relays with their edge detectors, inline.

#ifndef TRIBO_RELAY_KERNEL_H
#define TRIBO_RELAY_KERNEL_H

#include "tribo/relay.h"

/// All ones where bit 31 of x is set.
static inline uint32_t sign_mask(uint32_t x)
{
    return 0u - (x >> 31);
}

/// Comparators in front of the relays, Fig. 12, from signs: bits 31 of `inside` (|n| < c1 L), of `deep` (|n[k-1]| > c2 L on
/// its side) and of `back` (n has moved towards the other side). On the side where n is not, its set line rests. Reset
/// looks at n[k-1], so that one large step from above L2 to below it still counts as a crossing while decreasing (Fig. 5).
static inline uint32_t friction_relay_events(uint32_t side,
                                             uint32_t side_before,
                                             uint32_t inside,
                                             uint32_t deep,
                                             uint32_t back)
{
    // In a pair of lines, 2 - side is the one of the side where n is not.
    const uint32_t set   = (2u - side) | (sign_mask(inside) >> 30);
    const uint32_t reset = (2u - side_before) & sign_mask(deep & back);
    return set | (reset << 2);
}

/// Eq. (8): all ones where the relay of the side where n is not is high and `rise`, which is never -0, is above 0.
static inline uint32_t relay_armed_rise(uint32_t relays, uint32_t side, uint32_t rise)
{
    const uint32_t armed = relays << side; // in bit 1
    return sign_mask((armed << 30) & (0u - rise));
}

static inline uint32_t edge_kernel(tribo_edge_state_t *state, uint32_t width, uint32_t inputs)
{
    // Masked indices stay inside the line even if the state has been overwritten.
    const uint32_t head = state->head & TRIBO_EDGE_WIDTH_MAX;
    state->line[head]   = (uint8_t)inputs;
    const uint32_t past = state->line[(head - width) & TRIBO_EDGE_WIDTH_MAX];
    state->head         = (uint8_t)(head + 1u);
    return inputs & ~past;
}

static inline uint32_t relay_latch_kernel(tribo_relay_latch_t *latch, uint32_t pulses)
{
    // Relay 1 lives in bit 0 and relay 2 in bit 1 of every word here.
    const uint32_t held    = latch->held;
    const uint32_t set     = pulses & (TRIBO_RELAY_SET1 | TRIBO_RELAY_SET2);
    const uint32_t trigger = set | (pulses / TRIBO_RELAY_RESET1);
    const uint32_t rising  = trigger & ~(held >> 4);
    const uint32_t outputs = (held ^ ((held ^ set) & rising)) & (TRIBO_RELAY_Q1 | TRIBO_RELAY_Q2);

    latch->held = (uint8_t)(outputs | trigger << 4);
    return outputs;
}

/// What to put back so that the next step is as if the last had not been: its input goes where the last one's went.
typedef struct
{
    tribo_relay_latch_t latch;
    uint8_t             head;
} relay_mark_t;

static inline relay_mark_t relay_mark(const tribo_relay_state_t *state)
{
    return (relay_mark_t){.latch = state->latch, .head = state->edge.head};
}

static inline void relay_undo(tribo_relay_state_t *state, relay_mark_t mark)
{
    state->latch     = mark.latch;
    state->edge.head = mark.head;
}

static inline uint32_t relay_kernel(tribo_relay_state_t *state, uint32_t width, uint32_t events)
{
    return relay_latch_kernel(&state->latch, edge_kernel(&state->edge, width, events));
}

#endif
