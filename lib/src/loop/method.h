// What a tick does with a method: the loop does so with any method, an axis with its own. This text serves both
// arithmetics and is included after loop_f32.h or loop_q31.h.

/// The rest of a tick after its error `e`: the controller, and the term of a method, which then gets u. Without a
/// `memory` the term is `alone`. Returns u.
static inline force_t loop_method_step(const loop_params_t *params,
                                       NAME(controller, state_t) * state,
                                       const loop_functions_t *functions,
                                       void                   *memory,
                                       force_t                 alone,
                                       force_t                 e,
                                       loop_signals_t         *seen)
{
    const loop_controller_t *const controller = &params->controller;
    loop_nodes_t                   nodes;
    const force_t                  last = INNER(biquad, output)(&controller->cascade, &state->cascade, e, &nodes);
    const force_t term      = memory != NULL ? functions->term(params, memory, loop_v(controller, last)) : alone;
    const force_t u         = INNER(controller, apply)(controller, state, e, last, term, &nodes, &seen->controller);
    seen->OF(friction_term) = term;
    if (memory != NULL)
    {
        loop_rest(&seen->compensator);
        functions->after(params, memory, seen->controller.OF(v), u, seen);
    }
    return u;
}

/// The same with the output `v` of a controller of the caller's. `excess` becomes what the limit has cut off.
static inline force_t loop_method_command(const loop_params_t *params,
                                          NAME(controller, state_t) * state,
                                          uint32_t               *bad_inputs,
                                          const loop_functions_t *functions,
                                          void                   *memory,
                                          force_t                 v,
                                          force_t                *excess)
{
    const loop_controller_t *const controller = &params->controller;
    loop_signals_t                 signals;
    const force_t                  output = loop_credible(bad_inputs, v);
    force_t                        sum    = output;
    if (memory != NULL)
    {
        sum = loop_sum(bad_inputs, output, functions->term(params, memory, output));
    }
    const force_t u            = within_of(sum, controller->OF(u_min), controller->OF(u_max));
    signals.controller.limited = u != sum;
    if (u != sum)
    {
        count_one(&state->limited_ticks);
    }
    if (memory != NULL)
    {
        functions->after(params, memory, output, u, &signals);
    }
    *excess = minus(u, sum);
    return u;
}
