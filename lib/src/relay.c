#include "tribo/relay.h"

#include "relay_step.h"

#define EVENTS (TRIBO_RELAY_SET1 | TRIBO_RELAY_SET2 | TRIBO_RELAY_RESET1 | TRIBO_RELAY_RESET2)

void tribo_relay_reset(tribo_relay_state_t *state)
{
    tribo_edge_reset(&state->edge, TRIBO_RELAY_SET1 | TRIBO_RELAY_SET2);
    state->latch.held = 0;
}

uint8_t tribo_relay_latch_step(tribo_relay_latch_t *latch, uint8_t pulses)
{
    return (uint8_t)relay_latch_step(latch, pulses & EVENTS);
}

uint8_t tribo_relay_step(tribo_relay_state_t *state, uint8_t width, uint8_t events)
{
    return (uint8_t)relay_step(state, width, events & EVENTS);
}
