#include "tribo/force_loop_q31.h"

#include "tribo/force_loop_f32.h"

#include "../controller/anti_windup_q31.h"
#include "../friction/compensator_q31.h"
#include "../number/fixed_q31.h"
#include "../number/ranges.h"
#include "loop_q31.h"

tribo_status_t tribo_force_loop_q31_init(tribo_force_loop_q31_params_t       *params,
                                         tribo_breakaway_point_q31_t         *table,
                                         const tribo_force_loop_f32_config_t *config,
                                         float                                full_scale_n,
                                         tribo_headroom_q31_t                *headroom)
{
    tribo_force_loop_f32_params_t f32;
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_status_t status = tribo_force_loop_f32_init(&f32, config);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!full_scale_ok(full_scale_n))
    {
        return TRIBO_ERR_FULL_SCALE;
    }
    if (!within(config->input_max_n / full_scale_n, FIXED_Q31_SMALLEST, 1.0f))
    {
        return TRIBO_ERR_INPUT_MAX;
    }
    tribo_headroom_q31_t          measured;
    tribo_force_loop_q31_params_t made = {.input_max = fixed_input_max(config->input_max_n, full_scale_n),
                                          .gain      = fixed(f32.gain, FORCE_LOOP_Q31_GAIN_FRACTION)};

    status = tribo_controller_q31_init(&made.controller, &config->controller, full_scale_n, &measured);
    status = status != TRIBO_OK ? status
                                : tribo_compensator_q31_init(&made.compensator,
                                                             table,
                                                             &config->compensator,
                                                             config->sample_time_s,
                                                             full_scale_n);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (headroom != NULL)
    {
        *headroom = measured;
    }
    *params = made;
    return TRIBO_OK;
}

void tribo_force_loop_q31_reset(tribo_force_loop_q31_state_t *state)
{
    force_loop_q31_activate(state, NULL);
    state->memory      = NULL;
    state->memory_seal = ~(uintptr_t)NULL;
    state->guard       = NULL;
    state->guard_seal  = ~(uintptr_t)NULL;
    state->fade        = UINT32_MAX;
    state->friction    = 0;
    state->bad_inputs  = 0;
    state->saturated   = 0;
    tribo_controller_q31_reset(&state->controller);
    tribo_compensator_q31_reset(&state->compensator);
}

/// The guard, if any: judges the friction added in this tick, and sets the fade for the next. Returns f^ of the last tick,
/// faded.
static int32_t guarded_friction(const tribo_force_loop_q31_params_t *params,
                                tribo_force_loop_q31_state_t        *state,
                                const tribo_force_loop_q31_tick_t   *tick,
                                int32_t                              r,
                                int32_t                              y)
{
    uint32_t      not_counted = 0;
    const int32_t f           = force_loop_q31_faded(params, state);
    int32_t       judged      = 0;
    if (params->method == NULL)
    {
        judged = force_loop_q31_term(params, f, &not_counted);
    }
    else if (tick != NULL)
    {
        judged = tick->friction;
    }
    if (!loop_sealed(state->guard, state->guard_seal))
    {
        tribo_q31_count(&state->bad_inputs); // the fade stays
        return f;
    }
    state->fade = UINT32_MAX;
    if (state->guard != NULL)
    {
        const bool good = !force_loop_q31_bad(params, r, y);
        state->fade     = params->guard->step(params->guard, state->guard, r, y, judged, good);
    }
    return f;
}

/// Nothing seen. Member by member: a struct would be cleared by a call.
static void rest(tribo_compensator_q31_signals_t *signals)
{
    signals->force           = 0;
    signals->friction.n      = 0;
    signals->friction.L      = 0;
    signals->friction.rise   = 0;
    signals->friction.f      = 0;
    signals->friction.relays = 0;
}

int32_t tribo_force_loop_q31_step(const tribo_force_loop_q31_params_t *params,
                                  tribo_force_loop_q31_state_t        *state,
                                  int32_t                              r,
                                  int32_t                              y,
                                  tribo_force_loop_q31_signals_t      *signals)
{
    const tribo_force_loop_q31_method_t *const method = params->method; // null: the paper's

    tribo_force_loop_q31_functions_t functions;
    void *const                      memory = method != NULL ? force_loop_q31_memory(state) : NULL;
    if (memory != NULL)
    {
        method->functions(&functions);
    }

    tribo_force_loop_q31_signals_t        unseen;
    tribo_force_loop_q31_signals_t *const seen = signals != NULL ? signals : &unseen; // cppcheck-suppress uninitvar
    tribo_biquad_q31_outputs_t            nodes;

    // error, 0 for a bad input: u coasts on the controller's state
    int32_t e = 0;
    if (force_loop_q31_bad(params, r, y))
    {
        tribo_q31_count(&state->bad_inputs);
    }
    else
    {
        e = tribo_q31_subtract(r, y, &state->saturated);
    }
    if (state->active != params)
    {
        tribo_force_loop_q31_change(params, state, r, y, e);
    }
    if (memory != NULL)
    {
        e = functions.error(params, memory, r, y, force_loop_q31_fade(params, state));
    }
    else if (method != NULL && !loop_sealed(state->memory, state->memory_seal))
    {
        tribo_q31_count(&state->bad_inputs);
    }
    int32_t friction = state->friction;
    if (params->guard != NULL)
    {
        friction = guarded_friction(params, state, memory, r, y);
    }
    seen->e = e;

    // controller
    const tribo_controller_q31_params_t *const controller = &params->controller;
    const int32_t last = biquad_q31_output(&controller->cascade, &state->controller.cascade, e, &nodes);
    int32_t       term = 0;
    if (memory != NULL)
    {
        uint32_t not_counted = 0;
        term = functions.term(params, memory, tribo_q31_widen(last, controller->cascade.output_scale, &not_counted));
    }
    else if (method == NULL)
    {
        term = force_loop_q31_term(params, friction, &state->saturated);
    }
    const int32_t u     = controller_q31_apply(controller, &state->controller, last, term, &nodes, &seen->controller);
    seen->friction_term = term;

    // compensation
    if (state->active != params)
    {
        tribo_force_loop_q31_change_friction(params, state, seen->e, u);
    }
    if (method == NULL)
    {
        state->friction = compensator_q31_step(&params->compensator, &state->compensator, u, &seen->compensator);
    }
    else
    {
        rest(&seen->compensator);
        if (memory != NULL)
        {
            functions.after(params, memory, seen->controller.v, u, seen);
        }
    }
    return u;
}
