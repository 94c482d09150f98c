// A tick in two halves, between which the caller runs a controller of its own. This text serves both arithmetics and is
// included after loop_f32.h or loop_q31.h.

#include "begin.h"

#define loop_own_error   NAME(force_loop, error)
#define loop_own_command NAME(force_loop, command)

force_t loop_own_error(const loop_params_t *params, loop_state_t *state, force_t r, force_t y)
{
    loop_begun_t begun;
    return loop_begin(params, state, r, y, &begun);
}

force_t loop_own_command(const loop_params_t *params, loop_state_t *state, force_t v, force_t *excess)
{
    const loop_controller_t *const controller = &params->controller;
    void *const                    memory     = params->method != NULL ? loop_memory(state) : NULL;

    loop_functions_t functions;
    loop_signals_t   signals;
    const force_t    output = loop_credible(&state->bad_inputs, v);
    force_t          sum    = output;
    if (memory != NULL)
    {
        params->method->functions(&functions);
        sum = loop_sum(state, output, functions.term(params, memory, output));
    }
    const force_t u = within_of(sum, controller->OF(u_min), controller->OF(u_max));
    if (u != sum)
    {
        count_one(&state->controller.limited_ticks);
    }
    if (memory != NULL)
    {
        signals.controller.limited = u != sum;
        loop_rest(&signals.compensator);
        functions.after(params, memory, output, u, &signals);
    }
    loop_activate(state, params);
    *excess = minus(u, sum);
    return u;
}
