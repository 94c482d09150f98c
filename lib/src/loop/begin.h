// The first half of a tick, up to the controller's error. This text serves both arithmetics and is included after
// loop_f32.h or loop_q31.h.

#include "method.h"

/// What the first half leaves to the second.
typedef struct
{
    loop_functions_t functions;
    void            *memory;   ///< memory of the method; null if the controller runs alone
    force_t          friction; ///< f^ of the last tick, faded by the guard
} loop_begun_t;

/// The guard judges the friction added in this tick, and sets the fade for the next one. Returns f^ of the last tick,
/// faded. `tick` belongs to the method and is null without one.
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
    const bool good = !loop_input_is_bad(params, r, y);
    (void)params->guard->step(params->guard, &state->guard, r, y, judged, good);
    return f;
}

/// Counts a bad input, whose error is 0, takes over new params, and calls the method and the guard. Returns the
/// controller's error.
static inline force_t loop_begin(const loop_params_t *params,
                                 loop_state_t        *state,
                                 force_t              r,
                                 force_t              y,
                                 loop_begun_t        *begun)
{
    force_t e = 0;
    if (loop_input_is_bad(params, r, y))
    {
        count_one(&state->bad_inputs);
    }
    else
    {
        e = loop_error(loop_saturated(state), r, y);
    }
    if (state->active != params)
    {
        loop_change(params, state, r, y, e);
    }
    begun->memory = NULL;
    if (params->method != NULL)
    {
        begun->memory = loop_memory(state);
        if (begun->memory != NULL)
        {
            params->method->functions(&begun->functions);
            e = begun->functions.error(params, begun->memory, r, y, loop_fade(params, state));
        }
        else // the controller runs alone
        {
            count_one(&state->bad_inputs);
        }
    }
    begun->friction = state->OF(friction);
    if (params->guard != NULL)
    {
        begun->friction = guarded_friction(params, state, begun->memory, r, y);
    }
    return e;
}
