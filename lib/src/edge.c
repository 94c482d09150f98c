#include "tribo/edge.h"

void tribo_edge_reset(tribo_edge_state_t *state, uint8_t rest)
{
    for (uint32_t i = 0; i <= TRIBO_EDGE_WIDTH_MAX; i++)
    {
        state->line[i] = rest;
    }
    state->head = 0;
}

uint8_t tribo_edge_step(tribo_edge_state_t *state, uint8_t width, uint8_t inputs)
{
    // Masked indices stay inside the line even if the state has been overwritten.
    const uint32_t head = state->head & TRIBO_EDGE_WIDTH_MAX;
    state->line[head]   = inputs;
    const uint32_t past = state->line[(head - width) & TRIBO_EDGE_WIDTH_MAX];
    state->head         = (uint8_t)(head + 1u);
    return (uint8_t)(inputs & ~past);
}
