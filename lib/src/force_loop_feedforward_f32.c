#include "tribo/force_loop_feedforward_f32.h"

#include "controller_f32_step.h"
#include "feedforward_f32_step.h"
#include "force_loop_f32_step.h"

#include <stddef.h>

// Beyond any sum of credible forces, or any doubt: the memory is corrupt.
#define FORCE_MAX_N 1.0e9f
#define DOUBT_MAX   2.0f

tribo_status_t tribo_force_loop_feedforward_f32_init(tribo_force_loop_f32_params_t        *params,
                                                     tribo_feedforward_f32_params_t       *feedforward,
                                                     const tribo_force_loop_f32_config_t  *config,
                                                     const tribo_feedforward_f32_config_t *feedforward_config)
{
    tribo_force_loop_f32_params_t made;
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_status_t status = tribo_force_loop_f32_init(&made, config);
    if (status == TRIBO_OK)
    {
        status = tribo_feedforward_f32_init(feedforward,
                                            feedforward_config,
                                            &config->compensator,
                                            config->input_max_n,
                                            config->sample_time_s);
    }
    if (status == TRIBO_OK)
    {
        made.method      = &tribo_force_loop_feedforward_f32;
        made.feedforward = feedforward;
        *params          = made;
    }
    return status;
}

void tribo_force_loop_feedforward_f32_attach(tribo_force_loop_f32_state_t   *state,
                                             tribo_feedforward_f32_memory_t *memory)
{
    force_loop_f32_attach(state, memory);
    if (memory != NULL)
    {
        memory->signals = (tribo_feedforward_f32_signals_t){.e_n = 0.0f};
        tribo_feedforward_f32_restart(&memory->state);
    }
}

/// Before a tick: takes over from the params of the last one. From another method the feed-forward enters, adding what keeps u
/// where it was going to be; from params of its own it goes on adding what it added.
static void change(const tribo_force_loop_f32_params_t *params,
                   tribo_force_loop_f32_state_t        *state,
                   tribo_feedforward_f32_memory_t      *memory,
                   float                                r_n,
                   float                                y_n)
{
    const tribo_force_loop_f32_params_t *const from  = force_loop_f32_active(state, params);
    tribo_feedforward_f32_state_t *const       inner = &memory->state;
    if (from->method != params->method)
    {
        const float e      = force_loop_f32_bad(params, r_n, y_n) ? 0.0f : r_n - y_n;
        const float wanted = tribo_force_loop_f32_wanted(from, state, r_n, y_n);
        tribo_controller_f32_change(&from->controller, &params->controller, &state->controller, e, 0.0f);
        tribo_feedforward_f32_enter(inner, wanted - force_loop_f32_v(&params->controller, &state->controller, e));
    }
    else if (from != params)
    {
        const float e = memory->signals.e_n; // of the last tick; that of this one is near
        tribo_controller_f32_change(&from->controller, &params->controller, &state->controller, e, 0.0f);
        inner->entering = inner->running;
        inner->entry_n  = memory->signals.added_n;
    }
}

/// A tick without memory, or with a corrupt one: the controller alone has r - y.
static float error_alone(const tribo_force_loop_f32_params_t *params,
                         tribo_force_loop_f32_state_t        *state,
                         float                                r_n,
                         float                                y_n)
{
    if (force_loop_f32_bad(params, r_n, y_n))
    {
        count(&state->bad_inputs);
        return 0.0f;
    }
    return r_n - y_n;
}

static float step(const tribo_force_loop_f32_params_t *params,
                  tribo_force_loop_f32_state_t        *state,
                  float                                r_n,
                  float                                y_n,
                  tribo_force_loop_f32_signals_t      *signals)
{
    tribo_force_loop_f32_signals_t        unseen;
    tribo_force_loop_f32_signals_t *const seen = signals != NULL ? signals : &unseen; // cppcheck-suppress uninitvar

    const tribo_feedforward_f32_params_t *const feedforward = params->feedforward;
    const tribo_friction_f32_params_t *const    friction    = &params->compensator.friction;
    tribo_feedforward_f32_memory_t             *memory      = force_loop_f32_memory(state);
    if (state->active != params)
    {
        if (memory != NULL)
        {
            change(params, state, memory, r_n, y_n);
        }
        force_loop_f32_activate(state, params);
    }

    tribo_biquad_f32_outputs_t outputs;

    float e = 0.0f;
    if (memory != NULL)
    {
        tribo_feedforward_f32_signals_t *const inner = &memory->signals;
        e = feedforward_f32_before(feedforward, friction, &memory->state, r_n, y_n, inner);
        if (exceeds(e, FORCE_MAX_N) || exceeds(inner->lin_n + inner->f_n, FORCE_MAX_N) ||
            exceeds(inner->ahead.doubt, DOUBT_MAX))
        {
            tribo_feedforward_f32_reset(feedforward, &memory->state);
            memory = NULL;
        }
    }
    if (memory == NULL)
    {
        e = error_alone(params, state, r_n, y_n);
    }
    const float v     = biquad_f32_output(&params->controller.cascade, &state->controller.cascade, e, &outputs);
    const float added = memory != NULL ? feedforward_f32_added(feedforward, &memory->state, v, &memory->signals) : 0.0f;
    const float u =
        controller_f32_apply(&params->controller, &state->controller, e, v, added, &outputs, &seen->controller);

    seen->e_n           = e;
    seen->feedforward_n = added;
    if (memory == NULL)
    {
        seen->compensator = (tribo_compensator_f32_signals_t){.force_n = 0.0f};
        return u;
    }
    tribo_feedforward_f32_signals_t *const inner = &memory->signals;
    if (!inner->r_good || !inner->y_good)
    {
        count(&state->bad_inputs);
    }
    feedforward_f32_after(feedforward, friction, &memory->state, v, u, seen->controller.limited, inner);
    const float F = inner->reached_n + memory->state.path.arm.force_n;
    seen->compensator =
        (tribo_compensator_f32_signals_t){.force_n  = F,
                                          .friction = {.n_n = u - F, .L_n = inner->ahead.L_n, .f_n = inner->f_n}};
    return u;
}

/// With what was added in the last tick, and y expected as of then.
static float wanted(const tribo_force_loop_f32_params_t *params,
                    tribo_force_loop_f32_state_t        *state,
                    float                                r_n,
                    float                                y_n)
{
    const tribo_feedforward_f32_memory_t *const memory = force_loop_f32_memory(state);

    float e     = r_n - y_n;
    float added = 0.0f;
    if (memory != NULL)
    {
        e     = memory->signals.e_n + (memory->signals.y_n - y_n);
        added = memory->signals.added_n;
    }
    if (force_loop_f32_bad(params, r_n, y_n))
    {
        e = 0.0f;
    }
    return force_loop_f32_v(&params->controller, &state->controller, e) + added;
}

const tribo_force_loop_f32_method_t tribo_force_loop_feedforward_f32 = {.step      = step,
                                                                        .wanted    = wanted,
                                                                        .hand_over = tribo_force_loop_f32_hand_over};
