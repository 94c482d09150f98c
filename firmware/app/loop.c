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

loop_learned_t loop_learned(const loop_params_t *params,
                            const loop_memory_t *memory,
                            uint32_t             direction,
                            loop_force_t         at,
                            float                full_scale_n)
{
    loop_learned_t shown = {0};
    if (params->feedforward != NULL)
    {
        const FEED(learned_t) learned =
            FEED(learned)(params->feedforward, &params->compensator.friction, &memory->state, direction, at);
        shown = (loop_learned_t){.L_n      = LEARNED_N(learned.LOOP_N(L), full_scale_n),
                                 .doubt    = LEARNED_DOUBT(learned.doubt),
                                 .travel_n = LEARNED_N(learned.LOOP_N(travel), full_scale_n),
                                 .at_bound = learned.at_bound};
    }
    return shown;
}

bool loop_stays_at_bound(const loop_memory_t *memory, uint32_t direction)
{
    return memory->state.learning.stays_at_bound[direction] != 0u;
}

void loop_trust(loop_memory_t *memory)
{
    LEARNING(restore)(&memory->state.learning);
}

void loop_guard_reset(loop_guard_state_t *guard)
{
    GUARD(reset)(guard);
}

void loop_guard_begin(loop_guard_state_t *guard)
{
    const loop_guard_state_t was = *guard;
    GUARD(reset)(guard);
    guard->cause = was.cause;
    guard->share = was.share;
}

void loop_guard_enter(const loop_guard_state_t *guard, loop_memory_t *memory)
{
    memory->state.share = guard->share;
}

void loop_guard_restore(loop_guard_state_t *guard)
{
    GUARD(restore)(guard);
}

tribo_guard_cause_t loop_guard_cause(const loop_guard_state_t *guard)
{
    return guard->cause;
}

float loop_guard_share(const loop_guard_state_t *guard)
{
    return (float)guard->share * (1.0f / (float)LOOP_ALL);
}

void loop_guard_watch(const loop_guard_params_t *params,
                      loop_guard_state_t        *guard,
                      const loop_params_t       *loop_params,
                      loop_state_t              *loop,
                      loop_force_t               r,
                      loop_force_t               y,
                      const loop_signals_t      *signals)
{
    if (!params->on)
    {
        loop_guard_restore(guard);
    }
    LOOP_GUARD(&params->params, guard, loop_params, loop, r, y, signals);
}
#else
// NOLINTBEGIN(readability-non-const-parameter): a loop with a feed-forward writes it
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
// NOLINTEND(readability-non-const-parameter)
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
