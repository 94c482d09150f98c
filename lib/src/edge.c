#include "tribo/edge.h"

#include "relay_step.h"

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
    return (uint8_t)edge_step(state, width, inputs);
}
