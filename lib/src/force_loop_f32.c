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
    tribo_force_loop_f32_params_t made   = {.input_max = order_f32(config->input_max_n), .gain = config->gain};
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
        *params = made;
    }
    return status;
}

/// Two sections and no table: a tick of its own.
static bool is_usual(const tribo_force_loop_f32_params_t *params)
{
    return params->controller.cascade.count == 2u && params->compensator.friction.table == NULL;
}

void tribo_force_loop_f32_reset(tribo_force_loop_f32_state_t *state)
{
    state->active     = NULL;
    state->usual      = NULL;
    state->friction_n = 0.0f;
    state->bad_inputs = 0;
    tribo_controller_f32_reset(&state->controller);
    tribo_compensator_f32_reset(&state->compensator);
}

// Out of line: what a change of params needs shall not be on the stack of every tick, nor all of it at once.

/// What f^ of this tick is under params `p`: a step, undone for the one that follows. A copy of the state would fill the
/// stack.
static TRIBO_OUT_OF_LINE float friction_under(const tribo_force_loop_f32_params_t *p,
                                              tribo_compensator_f32_state_t       *state,
                                              float                                u_n,
                                              tribo_compensator_f32_signals_t     *scratch)
{
    tribo_friction_f32_state_t *const friction   = &state->friction;
    const tribo_arm_f32_state_t       arm        = state->arm;
    const relay_mark_t                relay      = relay_mark(&friction->relay);
    const float                       n_n        = friction->n_n;
    const uint32_t                    bad_inputs = friction->bad_inputs;

    const float f = tribo_compensator_f32_step(&p->compensator, state, u_n, scratch);

    state->arm = arm;
    relay_undo(&friction->relay, relay);
    friction->n_n        = n_n;
    friction->bad_inputs = bad_inputs;
    return f;
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
    signals->e_n                                    = e;
    signals->feedforward_n                          = feedforward;
    if (from != params)
    {
        const float by = -((params->gain - from->gain) * state->friction_n);
        tribo_controller_f32_change(&from->controller, &params->controller, &state->controller, e, by);
    }
    const float u =
        tribo_controller_f32_step(&params->controller, &state->controller, e, feedforward, &signals->controller);
    const float old   = from != params ? friction_under(from, &state->compensator, u, &signals->compensator) : 0.0f;
    state->friction_n = tribo_compensator_f32_step(&params->compensator, &state->compensator, u, &signals->compensator);
    if (from != params)
    {
        const float by = -(params->gain * (state->friction_n - old));
        tribo_controller_f32_change(&params->controller, &params->controller, &state->controller, e, by);
    }
    state->active = params;
    state->usual  = is_usual(params) ? params : NULL;
    return u;
}

static TRIBO_OUT_OF_LINE float tick_of_any_unseen(const tribo_force_loop_f32_params_t *params,
                                                  tribo_force_loop_f32_state_t        *state,
                                                  float                                e,
                                                  float                                feedforward)
{
    tribo_force_loop_f32_signals_t unseen;
    return tick_of_any(params, state, e, feedforward, &unseen);
}

/// A tick; where `seen`, a constant, is false, of usual params without a trace of `signals`.
static inline float tick(const tribo_force_loop_f32_params_t *params,
                         tribo_force_loop_f32_state_t        *state,
                         float                                r_n,
                         float                                y_n,
                         tribo_force_loop_f32_signals_t      *signals,
                         bool                                 seen)
{
    float e = 0.0f;
    if (TRIBO_USUAL(order_f32(r_n) <= params->input_max && order_f32(y_n) <= params->input_max))
    {
        e = r_n - y_n;
    }
    else
    {
        count(&state->bad_inputs);
    }
    const float added = params->gain * state->friction_n;
    if (!TRIBO_FAST_WAY(state->usual == params))
    {
        if (!TRIBO_FAST_WAY(is_usual(params) && state->active == NULL))
        {
            return seen ? tick_of_any(params, state, e, added, signals) : tick_of_any_unseen(params, state, e, added);
        }
        state->active = params; // the first tick
        state->usual  = params;
    }
    signals->e_n           = e;
    signals->feedforward_n = added;

    const float u = controller_f32_kernel(&params->controller, &state->controller, e, added, &signals->controller);
    state->friction_n =
        compensator_f32_kernel(&params->compensator, &state->compensator, u, &signals->compensator, false);
    return u;
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
