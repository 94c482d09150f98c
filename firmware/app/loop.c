#include "app/loop.h"

#include <stddef.h>

void loop_reset(loop_state_t *state)
{
    LOOP(reset)(state);
}

#if DRIVE_FEEDFORWARD
void loop_attach(loop_state_t *state, loop_memory_t *memory)
{
    LOOP_ATTACH(state, memory);
}

void loop_forget(const loop_params_t *params, loop_memory_t *memory)
{
    if (params->feedforward != NULL)
    {
        FEED(reset)(params->feedforward, &memory->state);
    }
}
#else
void loop_attach(loop_state_t *state, loop_memory_t *memory)
{
    (void)state;
    (void)memory;
}

void loop_forget(const loop_params_t *params, loop_memory_t *memory)
{
    (void)params;
    (void)memory;
}
#endif

loop_force_t loop_step(const loop_params_t *params,
                       loop_state_t        *state,
                       loop_force_t         r,
                       loop_force_t         y,
                       loop_signals_t      *signals)
{
    return LOOP(step)(params, state, r, y, signals);
}

loop_force_t loop_u_min(const loop_params_t *params)
{
    return params->controller.LOOP_N(u_min);
}

loop_force_t loop_u_max(const loop_params_t *params)
{
    return params->controller.LOOP_N(u_max);
}

loop_force_t loop_input_max(const loop_params_t *params)
{
    return params->LOOP_N(input_max);
}

loop_force_t loop_f_hat(const loop_signals_t *signals)
{
    return signals->compensator.LOOP_N(force);
}

void loop_words(const loop_signals_t *signals, uint32_t words[TRIBO_SIGNAL_WORDS])
{
    LOOP_TO_WORDS(signals, words);
}
