#include "tribo/force_loop_f32.h"

#include "compensator_f32_kernel.h"
#include "controller_f32_kernel.h"
#include "exact_f32.h"
#include "tribo/paper_controller.h"

#include <stddef.h>

tribo_force_loop_f32_config_t tribo_force_loop_f32_paper(void)
{
    const tribo_force_loop_f32_config_t paper = {
        .sample_time_s = TRIBO_PAPER_CONTROLLER_SAMPLE_TIME_S,
        .input_max_n   = 2.0f,
        .gain          = 0.85f,
        .controller    = {.sections      = tribo_paper_controller_f32,
                          .section_count = TRIBO_PAPER_CONTROLLER_SECTION_COUNT,
                          .u_min_n       = -2.0f,
                          .u_max_n       = 2.0f},
        .compensator   = tribo_compensator_f32_paper(),
    };
    return paper;
}

static tribo_status_t check(const tribo_force_loop_f32_config_t *config)
{
    if (!within(config->sample_time_s, 1.0e-6f, 0.1f))
    {
        return TRIBO_ERR_SAMPLE_TIME;
    }
    if (!within(config->input_max_n, FLT_MIN, TRIBO_F32_FORCE_MAX_N))
    {
        return TRIBO_ERR_INPUT_MAX;
    }
    if (!within(config->gain, 0.0f, 2.0f))
    {
        return TRIBO_ERR_GAIN;
    }
    return TRIBO_OK;
}

tribo_status_t tribo_force_loop_f32_init(tribo_force_loop_f32_params_t       *params,
                                         const tribo_force_loop_f32_config_t *config)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_force_loop_f32_params_t made   = {.input_end = order_f32(config->input_max_n) + 1u, .gain = config->gain};
    tribo_status_t                status = check(config);
    if (status == TRIBO_OK)
    {
        status = tribo_controller_f32_init(&made.controller, &config->controller);
    }
    if (status == TRIBO_OK)
    {
        status = tribo_compensator_f32_init(&made.compensator, &config->compensator, config->sample_time_s);
    }
    if (status == TRIBO_OK)
    {
        const bool usual     = made.controller.cascade.count == 2u && made.compensator.friction.table == NULL;
        made.usual_input_end = usual ? made.input_end : 0u;
        *params              = made;
    }
    return status;
}

void tribo_force_loop_f32_reset(tribo_force_loop_f32_state_t *state)
{
    state->active     = NULL;
    state->friction_n = 0.0f;
    state->bad_inputs = 0;
    tribo_controller_f32_reset(&state->controller);
    tribo_compensator_f32_reset(&state->compensator);
}

// Out of line: what a change of params needs shall not be on the stack of every tick, nor all of it at once.

/// What f^ of this tick is under params `p`: a step of the friction model, undone for the one that follows. A copy of the
/// state would fill the stack.
static TRIBO_OUT_OF_LINE float friction_under(const tribo_force_loop_f32_params_t *p,
                                              tribo_compensator_f32_state_t       *state,
                                              float                                u_n)
{
    tribo_friction_f32_state_t *const friction   = &state->friction;
    const relay_mark_t                relay      = relay_mark(&friction->relay);
    const float                       n_n        = friction->n_n;
    const uint32_t                    bad_inputs = friction->bad_inputs;
    tribo_friction_f32_signals_t      unseen;

    const float f = tribo_friction_f32_step(&p->compensator.friction, friction, u_n, state->arm.force_n, &unseen);

    relay_undo(&friction->relay, relay);
    friction->n_n        = n_n;
    friction->bad_inputs = bad_inputs;
    return f;
}

static TRIBO_OUT_OF_LINE float control(const tribo_force_loop_f32_params_t *params,
                                       tribo_force_loop_f32_state_t        *state,
                                       float                                e,
                                       float                                feedforward,
                                       tribo_force_loop_f32_signals_t      *signals)
{
    tribo_controller_f32_signals_t  unseen;
    tribo_controller_f32_signals_t *seen = &unseen;
    if (signals != NULL)
    {
        signals->e_n           = e;
        signals->feedforward_n = feedforward;
        seen                   = &signals->controller;
    }
    return tribo_controller_f32_step(&params->controller, &state->controller, e, feedforward, seen);
}

static TRIBO_OUT_OF_LINE float compensate(const tribo_force_loop_f32_params_t *params,
                                          tribo_force_loop_f32_state_t        *state,
                                          float                                u_n,
                                          tribo_force_loop_f32_signals_t      *signals)
{
    tribo_compensator_f32_signals_t unseen;
    return tribo_compensator_f32_step(&params->compensator,
                                      &state->compensator,
                                      u_n,
                                      signals != NULL ? &signals->compensator : &unseen);
}

/// The tick of any params, and where they change: the controller makes up for what another gain, and then what another
/// friction model, would add to u in one jump.
static TRIBO_OUT_OF_LINE float tick_of_any(const tribo_force_loop_f32_params_t *params,
                                           tribo_force_loop_f32_state_t        *state,
                                           float                                e,
                                           float                                feedforward,
                                           tribo_force_loop_f32_signals_t      *signals)
{
    const tribo_force_loop_f32_params_t *const from = state->active != NULL ? state->active : params;
    if (from != params)
    {
        const float by = -((params->gain - from->gain) * state->friction_n);
        tribo_controller_f32_change(&from->controller, &params->controller, &state->controller, e, by);
    }
    const float u     = control(params, state, e, feedforward, signals);
    const float old   = from != params ? friction_under(from, &state->compensator, u) : 0.0f;
    state->friction_n = compensate(params, state, u, signals);
    if (from != params)
    {
        const float by = -(params->gain * (state->friction_n - old));
        tribo_controller_f32_change(&params->controller, &params->controller, &state->controller, e, by);
    }
    state->active = params;
    return u;
}

static inline float usual_kernel(const tribo_force_loop_f32_params_t *params,
                                 tribo_force_loop_f32_state_t        *state,
                                 float                                e,
                                 float                                feedforward,
                                 tribo_force_loop_f32_signals_t      *signals)
{
    signals->e_n           = e;
    signals->feedforward_n = feedforward;

    const float u =
        controller_f32_kernel(&params->controller, &state->controller, e, feedforward, &signals->controller);
    state->friction_n = compensator_f32_kernel(&params->compensator, &state->compensator, u, &signals->compensator);
    return u;
}

static TRIBO_OWN_FRAME TRIBO_ALL_INLINE float usual_tick(const tribo_force_loop_f32_params_t *params,
                                                         tribo_force_loop_f32_state_t        *state,
                                                         float                                e,
                                                         float                                feedforward,
                                                         tribo_force_loop_f32_signals_t      *signals)
{
    return usual_kernel(params, state, e, feedforward, signals);
}

static TRIBO_OWN_FRAME TRIBO_ALL_INLINE float usual_tick_unseen(const tribo_force_loop_f32_params_t *params,
                                                                tribo_force_loop_f32_state_t        *state,
                                                                float                                e,
                                                                float                                feedforward)
{
    tribo_force_loop_f32_signals_t unseen;
    return usual_kernel(params, state, e, feedforward, &unseen);
}

/// |r| and |y| are below an end; a NaN is not.
static inline bool is_below(uint32_t end, float r_n, float y_n)
{
    return order_f32(r_n) < end && order_f32(y_n) < end;
}

/// A tick; where `seen`, a constant, is false, of usual params without a trace of `signals`.
static inline float tick(const tribo_force_loop_f32_params_t *params,
                         tribo_force_loop_f32_state_t        *state,
                         float                                r_n,
                         float                                y_n,
                         tribo_force_loop_f32_signals_t      *signals,
                         bool                                 seen)
{
    // 0 where params are not usual: the first compares serve them as well.
    const uint32_t usual_end = params->usual_input_end;
    float          e         = 0.0f;
    if (TRIBO_USUAL(is_below(usual_end, r_n, y_n)) || is_below(params->input_end, r_n, y_n))
    {
        e = r_n - y_n;
    }
    else
    {
        count(&state->bad_inputs);
    }
    const float added = params->gain * state->friction_n;
    if (!TRIBO_FAST_WAY(usual_end != 0u && state->active == params))
    {
        if (!TRIBO_FAST_WAY(usual_end != 0u && state->active == NULL))
        {
            return tick_of_any(params, state, e, added, seen ? signals : NULL);
        }
        state->active = params; // the first tick
    }
    return seen ? usual_tick(params, state, e, added, signals) : usual_tick_unseen(params, state, e, added);
}

// Two functions, as in one each would have room for the other's on its stack.

TRIBO_ALL_INLINE float tribo_force_loop_f32_step_with_signals(const tribo_force_loop_f32_params_t *params,
                                                              tribo_force_loop_f32_state_t        *state,
                                                              float                                r_n,
                                                              float                                y_n,
                                                              tribo_force_loop_f32_signals_t      *signals)
{
    return tick(params, state, r_n, y_n, signals, true);
}

TRIBO_ALL_INLINE float tribo_force_loop_f32_step_without_signals(const tribo_force_loop_f32_params_t *params,
                                                                 tribo_force_loop_f32_state_t        *state,
                                                                 float                                r_n,
                                                                 float                                y_n)
{
    tribo_force_loop_f32_signals_t unseen;
    return tick(params, state, r_n, y_n, &unseen, false);
}
