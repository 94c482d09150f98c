// One tick of the loop, Fig. 9, for every method. This text serves both arithmetics.

#include "begin.h"

#define loop_step NAME(force_loop, step)

tribo_status_t NAME(force_loop, start)(loop_state_t *state, const loop_params_t *params, bool keep_learned)
{
    if (state == NULL || params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    const bool was_started           = state->active_seal != 0u;
    const NAME(guard, state_t) guard = state->guard;
    state->guard                     = (NAME(guard, state_t)){.fade = ALL};
    if (keep_learned && was_started)
    {
        state->guard.cause = guard.cause;
        state->guard.fade  = guard.fade;
    }
    loop_activate(state, NULL);
    state->memory_seal  = ~(uintptr_t)state->memory;
    state->OF(friction) = 0;
    loop_reset_counters(state);
    NAME(controller, reset)(&state->controller);
    NAME(compensator, reset)(&state->compensator);
    if (params->method == NULL)
    {
        return TRIBO_OK;
    }
    if (state->memory == NULL)
    {
        return TRIBO_ERR_MEMORY;
    }
    loop_functions_t functions;
    params->method->functions(&functions);
    functions.start(state->memory, keep_learned);
    return TRIBO_OK;
}

force_t loop_step(const loop_params_t *params, loop_state_t *state, force_t r, force_t y, loop_signals_t *signals)
{
    loop_signals_t        unseen;
    loop_signals_t *const seen = signals != NULL ? signals : &unseen; // cppcheck-suppress uninitvar

    loop_begun_t  begun;
    const bool    is_paper = params->method == NULL;
    const force_t e        = loop_begin(params, state, r, y, &begun);
    const force_t alone    = is_paper ? loop_term(params, begun.friction, loop_saturated(state)) : 0;
    seen->OF(e)            = e;
    const force_t u = loop_method_step(params, &state->controller, &begun.functions, begun.memory, alone, e, seen);
    if (is_paper) // computes the friction of this tick; a method has taken what it needs
    {
        if (state->active != params)
        {
            loop_change_friction(params, state, e, u);
        }
        state->OF(friction) = compensator_tick(&params->compensator, &state->compensator, u, &seen->compensator);
    }
    else if (begun.memory == NULL)
    {
        loop_rest(&seen->compensator);
    }
    return u;
}
