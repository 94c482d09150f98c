#include "tribo/relay.h"

#include "relay_kernel.h"

void tribo_relay_reset(tribo_relay_state_t *state)
{
    tribo_edge_reset(&state->edge, TRIBO_RELAY_SET1 | TRIBO_RELAY_SET2);
    state->latch.held = 0;
}

uint8_t tribo_relay_latch_step(tribo_relay_latch_t *latch, uint8_t pulses)
{
    return (uint8_t)relay_latch_kernel(latch, pulses & 15u);
}

uint8_t tribo_relay_step(tribo_relay_state_t *state, uint8_t width, uint8_t events)
{
    return (uint8_t)relay_kernel(state, width, events & 15u);
}
