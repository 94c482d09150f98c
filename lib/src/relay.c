#include "tribo/relay.h"

void tribo_relay_reset(tribo_relay_state_t *state)
{
    tribo_edge_reset(&state->edge, TRIBO_RELAY_SET1 | TRIBO_RELAY_SET2);
    state->latch.outputs = 0;
    state->latch.trigger = 0;
}

uint8_t tribo_relay_latch_step(tribo_relay_latch_t *latch, uint8_t pulses)
{
    // Relay 1 lives in bit 0 and relay 2 in bit 1 of every word here.
    const uint32_t set     = pulses & (TRIBO_RELAY_SET1 | TRIBO_RELAY_SET2);
    const uint32_t reset   = (pulses / TRIBO_RELAY_RESET1) & 3u;
    const uint32_t trigger = set | reset;
    const uint32_t rising  = trigger & ~(uint32_t)latch->trigger;

    latch->trigger = (uint8_t)trigger;
    latch->outputs = (uint8_t)((latch->outputs & ~rising) | (set & rising));
    return latch->outputs;
}

uint8_t tribo_relay_step(tribo_relay_state_t *state, uint8_t width, uint8_t events)
{
    return tribo_relay_latch_step(&state->latch, tribo_edge_step(&state->edge, width, events));
}
