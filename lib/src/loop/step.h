// One tick of the loop, Fig. 9, for every method. This text serves both arithmetics.

#include "begin.h"

#define loop_start NAME(force_loop, start)
#define loop_step  NAME(force_loop, step)

tribo_status_t loop_start(loop_state_t *state, const loop_params_t *params, bool keep_learned)
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
    const loop_method_t *const method = params->method; // null means the paper's method
    loop_signals_t             unseen;
    loop_signals_t *const      seen = signals != NULL ? signals : &unseen; // cppcheck-suppress uninitvar

    loop_begun_t  begun;
    const force_t e = loop_begin(params, state, r, y, &begun);
    seen->OF(e)     = e;

    // The controller, and what is added to its output v.
    const loop_controller_t *const controller = &params->controller;
    loop_nodes_t                   nodes;
    const force_t last = INNER(biquad, output)(&controller->cascade, &state->controller.cascade, e, &nodes);
    force_t       term = 0;
    if (method == NULL)
    {
        term = loop_term(params, begun.friction, loop_saturated(state));
    }
    else if (begun.memory != NULL)
    {
        term = begun.functions.term(params, begun.memory, loop_v(controller, last));
    }
    const force_t u         = loop_apply(controller, &state->controller, e, last, term, &nodes, &seen->controller);
    seen->OF(friction_term) = term;

    // The paper's method computes the friction of this tick. Another method takes what it needs from the tick.
    if (state->active != params)
    {
        loop_change_friction(params, state, e, u);
    }
    if (method == NULL)
    {
        state->OF(friction) = compensator_tick(&params->compensator, &state->compensator, u, &seen->compensator);
        return u;
    }
    loop_rest(&seen->compensator);
    if (begun.memory != NULL)
    {
        begun.functions.after(params, begun.memory, seen->controller.OF(v), u, seen);
    }
    return u;
}
