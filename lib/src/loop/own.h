// A tick in two halves, between which the caller runs a controller of its own. This text serves both arithmetics and is
// included after loop_f32.h or loop_q31.h.

#include "begin.h"

force_t NAME(force_loop, error)(const loop_params_t *params, loop_state_t *state, force_t r, force_t y)
{
    loop_begun_t begun;
    return loop_begin(params, state, r, y, &begun);
}

force_t NAME(force_loop, command)(const loop_params_t *params, loop_state_t *state, force_t v, force_t *excess)
{
    void *const      memory = params->method != NULL ? loop_memory(state) : NULL;
    loop_functions_t functions;
    if (memory != NULL)
    {
        params->method->functions(&functions);
    }
    loop_activate(state, params);
    return loop_method_command(params, &state->controller, &state->bad_inputs, &functions, memory, v, excess);
}
