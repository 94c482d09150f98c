// One tick of the loop, Fig. 9, for every method: a text for both arithmetics.

#define loop_reset NAME(force_loop, reset)
#define loop_step  NAME(force_loop, step)

void loop_reset(loop_state_t *state)
{
    loop_activate(state, NULL);
    state->memory       = NULL;
    state->memory_seal  = ~(uintptr_t)NULL;
    state->guard        = NULL;
    state->guard_seal   = ~(uintptr_t)NULL;
    state->fade         = ALL;
    state->OF(friction) = 0;
    loop_reset_counters(state);
    NAME(controller, reset)(&state->controller);
    NAME(compensator, reset)(&state->compensator);
}

/// The guard judges the friction added in this tick, and sets the fade for the next. Returns f^ of the last tick, faded. `tick` is of
/// the method, if any.
static force_t guarded_friction(const loop_params_t *params,
                                loop_state_t        *state,
                                const loop_tick_t   *tick,
                                force_t              r,
                                force_t              y)
{
    uint32_t      not_counted = 0;
    const force_t f           = loop_faded(params, state);
    force_t       judged      = 0;
    if (params->method == NULL)
    {
        judged = loop_term(params, f, &not_counted);
    }
    else if (tick != NULL)
    {
        judged = tick->OF(friction);
    }
    if (!loop_sealed(state->guard, state->guard_seal))
    {
        count_one(&state->bad_inputs); // the fade stays
        return f;
    }
    state->fade = ALL;
    if (state->guard != NULL)
    {
        const bool good = !loop_input_is_bad(params, r, y);
        state->fade     = params->guard->step(params->guard, state->guard, r, y, judged, good);
    }
    return f;
}

/// The controller's error by the method; `e` where the method has no memory, and the controller is alone.
static force_t method_error(const loop_params_t *params,
                            loop_state_t        *state,
                            void                *memory,
                            loop_functions_t    *functions,
                            force_t              r,
                            force_t              y,
                            force_t              e)
{
    if (memory == NULL)
    {
        if (!loop_sealed(state->memory, state->memory_seal))
        {
            count_one(&state->bad_inputs);
        }
        return e;
    }
    params->method->functions(functions);
    return functions->error(params, memory, r, y, loop_fade(params, state));
}

force_t loop_step(const loop_params_t *params, loop_state_t *state, force_t r, force_t y, loop_signals_t *signals)
{
    const loop_method_t *const method = params->method; // null: the paper's
    loop_functions_t           functions;
    void                      *memory = NULL; // of the method; null: the controller is alone
    loop_signals_t             unseen;
    loop_signals_t *const      seen = signals != NULL ? signals : &unseen; // cppcheck-suppress uninitvar

    // The error is 0 for a bad input: u coasts on the controller's state.
    force_t e = 0;
    if (loop_input_is_bad(params, r, y))
    {
        count_one(&state->bad_inputs);
    }
    else
    {
        e = loop_error(state, r, y);
    }
    if (state->active != params)
    {
        loop_change(params, state, r, y, e);
    }
    if (method != NULL)
    {
        memory = loop_memory(state);
        e      = method_error(params, state, memory, &functions, r, y, e);
    }
    force_t friction = state->OF(friction);
    if (params->guard != NULL)
    {
        friction = guarded_friction(params, state, memory, r, y);
    }
    seen->OF(e) = e;

    // The controller, and what is added to its output v.
    const loop_controller_t *const controller = &params->controller;
    loop_nodes_t                   nodes;
    const force_t last = PART(biquad, output)(&controller->cascade, &state->controller.cascade, e, &nodes);
    force_t       term = 0;
    if (method == NULL)
    {
        term = loop_term(params, friction, loop_saturated(state));
    }
    else if (memory != NULL)
    {
        term = functions.term(params, memory, loop_v(controller, last));
    }
    const force_t u         = loop_apply(controller, &state->controller, e, last, term, &nodes, &seen->controller);
    seen->OF(friction_term) = term;

    // The friction of this tick, by the paper's method, or what another takes from the tick.
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
    if (memory != NULL)
    {
        functions.after(params, memory, seen->controller.OF(v), u, seen);
    }
    return u;
}
