#include "tribo/force_loop_q31.h"

#include "compensator_q31_kernel.h"
#include "controller_q31_kernel.h"

#include <stdbool.h>
#include <stddef.h>

#define FEEDFORWARD_FRACTION 29 // of the gain

/// Two sections, plain friction and a feedforward that cannot saturate: a tick of its own.
static bool is_usual(const tribo_force_loop_q31_params_t *params)
{
    return params->controller.cascade.count == 2u && params->compensator.friction.plain &&
           params->gain <= INT32_C(1) << FEEDFORWARD_FRACTION;
}

void tribo_force_loop_q31_reset(tribo_force_loop_q31_state_t *state)
{
    state->active     = NULL;
    state->usual      = NULL;
    state->friction   = 0;
    state->bad_inputs = 0;
    state->saturated  = 0;
    tribo_controller_q31_reset(&state->controller);
    tribo_compensator_q31_reset(&state->compensator);
}

/// What friction f adds to u, Q31.
static inline int32_t feedforward(const tribo_force_loop_q31_params_t *params, int32_t f, uint32_t *saturated)
{
    return tribo_q31_narrow(tribo_q31_multiply(params->gain, f), FEEDFORWARD_FRACTION, saturated);
}

/// The same with usual params.
static inline int32_t usual_feedforward(const tribo_force_loop_q31_params_t *params, int32_t f)
{
    return (int32_t)(tribo_q31_multiply(params->gain, f) >> FEEDFORWARD_FRACTION);
}

// Out of line: what a change of params needs shall not be on the stack of every tick, nor all of it at once.

/// What f^ of this tick is under params `p`: a step, undone for the one that follows. A copy of the state would fill the
/// stack.
static TRIBO_OUT_OF_LINE int32_t friction_under(const tribo_force_loop_q31_params_t *p,
                                                tribo_compensator_q31_state_t       *state,
                                                int32_t                              u,
                                                tribo_compensator_q31_signals_t     *scratch)
{
    tribo_friction_q31_state_t *const friction  = &state->friction;
    const tribo_arm_q31_state_t       arm       = state->arm;
    const relay_mark_t                relay     = relay_mark(&friction->relay);
    const int32_t                     n         = friction->n;
    const uint32_t                    saturated = friction->saturated;

    const int32_t f = tribo_compensator_q31_step(&p->compensator, state, u, scratch);

    state->arm = arm;
    relay_undo(&friction->relay, relay);
    friction->n         = n;
    friction->saturated = saturated;
    return f;
}

/// What keeps u as it was: gain f of `from` less that of `params`.
static TRIBO_OUT_OF_LINE int32_t offset(const tribo_force_loop_q31_params_t *from,
                                        int32_t                              from_f,
                                        const tribo_force_loop_q31_params_t *params,
                                        int32_t                              f)
{
    uint32_t      not_counted = 0;
    const int64_t was         = feedforward(from, from_f, &not_counted);
    return tribo_q31_saturate(was - feedforward(params, f, &not_counted), &not_counted);
}

/// The tick of any params, and where they change: the controller makes up for what another gain, and then what another
/// friction model, would add to u in one jump.
static TRIBO_OUT_OF_LINE int32_t tick_of_any(const tribo_force_loop_q31_params_t *params,
                                             tribo_force_loop_q31_state_t        *state,
                                             int32_t                              e,
                                             tribo_force_loop_q31_signals_t      *signals)
{
    const tribo_force_loop_q31_params_t *const from  = state->active != NULL ? state->active : params;
    const int32_t                              added = feedforward(params, state->friction, &state->saturated);
    signals->e                                       = e;
    signals->feedforward                             = added;
    if (from != params)
    {
        const int32_t by = offset(from, state->friction, params, state->friction);
        tribo_controller_q31_change(&from->controller, &params->controller, &state->controller, e, by);
    }
    const int32_t u =
        tribo_controller_q31_step(&params->controller, &state->controller, e, added, &signals->controller);
    const int32_t old = from != params ? friction_under(from, &state->compensator, u, &signals->compensator) : 0;
    state->friction   = tribo_compensator_q31_step(&params->compensator, &state->compensator, u, &signals->compensator);
    if (from != params)
    {
        const int32_t by = offset(params, old, params, state->friction);
        tribo_controller_q31_change(&params->controller, &params->controller, &state->controller, e, by);
    }
    state->active = params;
    state->usual  = is_usual(params) ? params : NULL;
    return u;
}

static TRIBO_OUT_OF_LINE int32_t tick_of_any_unseen(const tribo_force_loop_q31_params_t *params,
                                                    tribo_force_loop_q31_state_t        *state,
                                                    int32_t                              e)
{
    tribo_force_loop_q31_signals_t unseen;
    return tick_of_any(params, state, e, &unseen);
}

/// A tick; where `seen`, a constant, is false, of usual params without a trace of `signals`.
static inline int32_t tick(const tribo_force_loop_q31_params_t *params,
                           tribo_force_loop_q31_state_t        *state,
                           int32_t                              r,
                           int32_t                              y,
                           tribo_force_loop_q31_signals_t      *signals,
                           bool                                 seen)
{
    // One compare an input: x from -end to end - 1 is x + end below 2 end, which is 2^32 for full scale.
    const uint32_t end = params->input_end;
    int32_t        e   = 0;
    if (TRIBO_USUAL(((uint32_t)r + end) >> 1 < end && ((uint32_t)y + end) >> 1 < end))
    {
        e = tribo_q31_subtract(r, y, &state->saturated);
    }
    else
    {
        tribo_q31_count(&state->bad_inputs);
    }
    if (!TRIBO_FAST_WAY(state->usual == params))
    {
        if (!TRIBO_FAST_WAY(is_usual(params) && state->active == NULL))
        {
            return seen ? tick_of_any(params, state, e, signals) : tick_of_any_unseen(params, state, e);
        }
        state->active = params; // the first tick
        state->usual  = params;
    }
    const int32_t added  = usual_feedforward(params, state->friction);
    signals->e           = e;
    signals->feedforward = added;

    const int32_t u = controller_q31_kernel(&params->controller, &state->controller, e, added, &signals->controller);
    state->friction =
        compensator_q31_kernel(&params->compensator, &state->compensator, u, &signals->compensator, false);
    return u;
}

// Two functions, as in one each would have room for the other's on its stack.

TRIBO_ALL_INLINE int32_t tribo_force_loop_q31_step_with_signals(const tribo_force_loop_q31_params_t *params,
                                                                tribo_force_loop_q31_state_t        *state,
                                                                int32_t                              r,
                                                                int32_t                              y,
                                                                tribo_force_loop_q31_signals_t      *signals)
{
    return tick(params, state, r, y, signals, true);
}

TRIBO_ALL_INLINE int32_t tribo_force_loop_q31_step_without_signals(const tribo_force_loop_q31_params_t *params,
                                                                   tribo_force_loop_q31_state_t        *state,
                                                                   int32_t                              r,
                                                                   int32_t                              y)
{
    tribo_force_loop_q31_signals_t unseen;
    return tick(params, state, r, y, &unseen, false);
}
