#include "tribo/force_loop_q31.h"

#include "compensator_q31_kernel.h"
#include "controller_q31_kernel.h"

#include <stdbool.h>
#include <stddef.h>

#define FEEDFORWARD_FRACTION 29 // of the gain

void tribo_force_loop_q31_reset(tribo_force_loop_q31_state_t *state)
{
    state->active     = NULL;
    state->friction   = 0;
    state->bad_inputs = 0;
    state->saturated  = 0;
    tribo_controller_q31_reset(&state->controller);
    tribo_compensator_q31_reset(&state->compensator);
}

/// What friction f adds to u, Q31.
static TRIBO_OUT_OF_LINE int32_t feedforward(const tribo_force_loop_q31_params_t *params,
                                             int32_t                              f,
                                             uint32_t                            *saturated)
{
    return tribo_q31_narrow(tribo_q31_multiply(params->gain, f), FEEDFORWARD_FRACTION, saturated);
}

/// The same with usual params.
static inline int32_t usual_feedforward(const tribo_force_loop_q31_params_t *params, int32_t f)
{
    return (int32_t)(tribo_q31_multiply(params->gain, f) >> FEEDFORWARD_FRACTION);
}

// Out of line: what a change of params needs shall not be on the stack of every tick, nor all of it at once.

/// What f^ of this tick is under params `p`: a step of the friction model, undone for the one that follows. A copy of the
/// state would fill the stack.
static TRIBO_OUT_OF_LINE int32_t friction_under(const tribo_force_loop_q31_params_t *p,
                                                tribo_compensator_q31_state_t       *state,
                                                int32_t                              u)
{
    tribo_friction_q31_state_t *const friction  = &state->friction;
    const relay_mark_t                relay     = relay_mark(&friction->relay);
    const int32_t                     n         = friction->n;
    const uint32_t                    saturated = friction->saturated;
    tribo_friction_q31_signals_t      unseen;

    const int32_t force = tribo_arm_q31_force(&state->arm);
    const int32_t f     = tribo_friction_q31_step(&p->compensator.friction, friction, u, force, &unseen);

    relay_undo(&friction->relay, relay);
    friction->n         = n;
    friction->saturated = saturated;
    return f;
}

/// The controller makes up for what the gain and friction of `to` instead of those of `from` would add to u in one jump.
static TRIBO_OUT_OF_LINE void change(const tribo_force_loop_q31_params_t *from,
                                     int32_t                              from_f,
                                     const tribo_force_loop_q31_params_t *to,
                                     int32_t                              to_f,
                                     tribo_force_loop_q31_state_t        *state,
                                     int32_t                              e)
{
    uint32_t      not_counted = 0;
    const int64_t was         = feedforward(from, from_f, &not_counted);
    const int32_t by          = tribo_q31_saturate(was - feedforward(to, to_f, &not_counted), &not_counted);
    // Not by way of the controller's, which is a frame more on the stack.
    tribo_biquad_q31_change(&from->controller.cascade, &to->controller.cascade, &state->controller.cascade, e, by);
}

static TRIBO_OUT_OF_LINE int32_t control(const tribo_force_loop_q31_params_t *params,
                                         tribo_force_loop_q31_state_t        *state,
                                         int32_t                              e,
                                         tribo_force_loop_q31_signals_t      *signals)
{
    tribo_controller_q31_signals_t  unseen;
    tribo_controller_q31_signals_t *seen  = &unseen;
    const int32_t                   added = feedforward(params, state->friction, &state->saturated);
    if (signals != NULL)
    {
        signals->e           = e;
        signals->feedforward = added;
        seen                 = &signals->controller;
    }
    return tribo_controller_q31_step(&params->controller, &state->controller, e, added, seen);
}

static TRIBO_OUT_OF_LINE int32_t compensate(const tribo_force_loop_q31_params_t *params,
                                            tribo_force_loop_q31_state_t        *state,
                                            int32_t                              u,
                                            tribo_force_loop_q31_signals_t      *signals)
{
    tribo_compensator_q31_signals_t unseen;
    return tribo_compensator_q31_step(&params->compensator,
                                      &state->compensator,
                                      u,
                                      signals != NULL ? &signals->compensator : &unseen);
}

/// The tick of any params, and where they change: the gain first, then the friction model.
static TRIBO_OUT_OF_LINE int32_t tick_of_any(const tribo_force_loop_q31_params_t *params,
                                             tribo_force_loop_q31_state_t        *state,
                                             int32_t                              e,
                                             tribo_force_loop_q31_signals_t      *signals)
{
    const tribo_force_loop_q31_params_t *const from = state->active != NULL ? state->active : params;
    if (from != params)
    {
        change(from, state->friction, params, state->friction, state, e);
    }
    const int32_t u   = control(params, state, e, signals);
    const int32_t old = from != params ? friction_under(from, &state->compensator, u) : 0;
    state->friction   = compensate(params, state, u, signals);
    if (from != params)
    {
        change(params, old, params, state->friction, state, e);
    }
    state->active = params;
    return u;
}

/// The tick of usual params.
static inline int32_t usual_kernel(const tribo_force_loop_q31_params_t *params,
                                   tribo_force_loop_q31_state_t        *state,
                                   int32_t                              e,
                                   tribo_force_loop_q31_signals_t      *signals)
{
    const int32_t added  = usual_feedforward(params, state->friction);
    signals->e           = e;
    signals->feedforward = added;

    const int32_t u = controller_q31_kernel(&params->controller, &state->controller, e, added, &signals->controller);
    state->friction = compensator_q31_kernel(&params->compensator, &state->compensator, u, &signals->compensator);
    return u;
}

static TRIBO_OWN_FRAME TRIBO_ALL_INLINE int32_t usual_tick(const tribo_force_loop_q31_params_t *params,
                                                           tribo_force_loop_q31_state_t        *state,
                                                           int32_t                              e,
                                                           tribo_force_loop_q31_signals_t      *signals)
{
    return usual_kernel(params, state, e, signals);
}

static TRIBO_OWN_FRAME TRIBO_ALL_INLINE int32_t usual_tick_unseen(const tribo_force_loop_q31_params_t *params,
                                                                  tribo_force_loop_q31_state_t        *state,
                                                                  int32_t                              e)
{
    tribo_force_loop_q31_signals_t unseen;
    return usual_kernel(params, state, e, &unseen);
}

/// r and y are from -end to end - 1.
static inline bool is_within(uint32_t end, int32_t r, int32_t y)
{
    // One compare an input: x + end below 2 end, which is 2^32 for full scale.
    return ((uint32_t)r + end) >> 1 < end && ((uint32_t)y + end) >> 1 < end;
}

/// A tick; where `seen`, a constant, is false, of usual params without a trace of `signals`.
static inline int32_t tick(const tribo_force_loop_q31_params_t *params,
                           tribo_force_loop_q31_state_t        *state,
                           int32_t                              r,
                           int32_t                              y,
                           tribo_force_loop_q31_signals_t      *signals,
                           bool                                 seen)
{
    // 0 where params are not usual: the first compares serve them as well.
    const uint32_t usual_end = params->usual_input_end;
    int32_t        e         = 0;
    if (TRIBO_USUAL(is_within(usual_end, r, y)) || is_within(params->input_end, r, y))
    {
        e = tribo_q31_subtract(r, y, &state->saturated);
    }
    else
    {
        tribo_q31_count(&state->bad_inputs);
    }
    if (!TRIBO_FAST_WAY(usual_end != 0u && state->active == params))
    {
        if (!TRIBO_FAST_WAY(usual_end != 0u && state->active == NULL))
        {
            return tick_of_any(params, state, e, seen ? signals : NULL);
        }
        state->active = params; // the first tick
    }
    return seen ? usual_tick(params, state, e, signals) : usual_tick_unseen(params, state, e);
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
