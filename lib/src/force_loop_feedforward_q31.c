#include "tribo/force_loop_feedforward_q31.h"

#include "controller_q31_step.h"
#include "feedforward_q31_step.h"
#include "force_loop_q31_step.h"
#include "tribo/quantize_feedforward_q31.h"

#include <stddef.h>

tribo_status_t tribo_force_loop_feedforward_q31_init(tribo_force_loop_q31_params_t        *params,
                                                     tribo_breakaway_point_q31_t          *table,
                                                     tribo_feedforward_q31_params_t       *feedforward,
                                                     const tribo_force_loop_f32_config_t  *config,
                                                     const tribo_feedforward_f32_config_t *feedforward_config,
                                                     float                                 full_scale_n,
                                                     tribo_headroom_q31_t                 *headroom)
{
    tribo_force_loop_q31_params_t made;
    tribo_headroom_q31_t          measured;
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_status_t status = tribo_force_loop_q31_init(&made, table, config, full_scale_n, &measured);
    if (status == TRIBO_OK)
    {
        status = tribo_feedforward_q31_init(feedforward,
                                            feedforward_config,
                                            &config->compensator,
                                            config->input_max_n,
                                            config->sample_time_s,
                                            full_scale_n);
    }
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (headroom != NULL)
    {
        *headroom = measured;
    }
    made.method      = &tribo_force_loop_feedforward_q31;
    made.feedforward = feedforward;
    *params          = made;
    return TRIBO_OK;
}

void tribo_force_loop_feedforward_q31_attach(tribo_force_loop_q31_state_t   *state,
                                             tribo_feedforward_q31_memory_t *memory)
{
    force_loop_q31_attach(state, memory);
    if (memory != NULL)
    {
        memory->signals = (tribo_feedforward_q31_signals_t){.e = 0};
        tribo_feedforward_q31_restart(&memory->state);
    }
}

/// Before a tick: takes over from the params of the last one. From another method the feed-forward enters, adding what keeps u
/// where it was going to be; from params of its own it goes on adding what it added.
static void change(const tribo_force_loop_q31_params_t *params,
                   tribo_force_loop_q31_state_t        *state,
                   tribo_feedforward_q31_memory_t      *memory,
                   int32_t                              r,
                   int32_t                              y)
{
    const tribo_force_loop_q31_params_t *const from        = force_loop_q31_active(state, params);
    tribo_feedforward_q31_state_t *const       inner       = &memory->state;
    uint32_t                                   not_counted = 0;
    if (from->method != params->method)
    {
        const int32_t e      = force_loop_q31_error(params, r, y, &not_counted);
        const int32_t wanted = tribo_force_loop_q31_wanted(from, state, r, y);
        tribo_controller_q31_change(&from->controller, &params->controller, &state->controller, e, 0);
        const int32_t v = force_loop_q31_v(&params->controller, &state->controller, e);
        tribo_feedforward_q31_enter(inner, tribo_q31_subtract(wanted, v, &not_counted));
    }
    else if (from != params)
    {
        tribo_controller_q31_change(&from->controller, &params->controller, &state->controller, memory->signals.e, 0);
        inner->entering = inner->running;
        inner->entry    = memory->signals.added;
    }
}

/// A tick without memory: the controller alone has r - y.
static int32_t error_alone(const tribo_force_loop_q31_params_t *params,
                           tribo_force_loop_q31_state_t        *state,
                           int32_t                              r,
                           int32_t                              y)
{
    if (force_loop_q31_bad(params, r, y))
    {
        tribo_q31_count(&state->bad_inputs);
    }
    return force_loop_q31_error(params, r, y, &state->saturated);
}

static int32_t step(const tribo_force_loop_q31_params_t *params,
                    tribo_force_loop_q31_state_t        *state,
                    int32_t                              r,
                    int32_t                              y,
                    tribo_force_loop_q31_signals_t      *signals)
{
    tribo_force_loop_q31_signals_t        unseen;
    tribo_force_loop_q31_signals_t *const seen = signals != NULL ? signals : &unseen; // cppcheck-suppress uninitvar

    const tribo_feedforward_q31_params_t *const feedforward = params->feedforward;
    const tribo_friction_q31_params_t *const    friction    = &params->compensator.friction;
    tribo_feedforward_q31_memory_t *const       memory      = force_loop_q31_memory(state);
    if (state->active != params)
    {
        if (memory != NULL)
        {
            change(params, state, memory, r, y);
        }
        force_loop_q31_activate(state, params);
    }

    tribo_biquad_q31_outputs_t outputs;
    uint32_t                   not_counted = 0;

    const int32_t e     = memory != NULL
                              ? feedforward_q31_before(feedforward, friction, &memory->state, r, y, &memory->signals)
                              : error_alone(params, state, r, y);
    const int32_t last  = biquad_q31_output(&params->controller.cascade, &state->controller.cascade, e, &outputs);
    const int32_t v     = tribo_q31_widen(last, params->controller.cascade.output_scale, &not_counted);
    const int32_t added = memory != NULL ? feedforward_q31_added(feedforward, &memory->state, v, &memory->signals) : 0;
    const int32_t u =
        controller_q31_apply(&params->controller, &state->controller, last, added, &outputs, &seen->controller);

    seen->e           = e;
    seen->feedforward = added;
    if (memory == NULL)
    {
        seen->compensator = (tribo_compensator_q31_signals_t){.force = 0};
        return u;
    }
    tribo_feedforward_q31_signals_t *const inner = &memory->signals;
    if (!inner->r_good || !inner->y_good)
    {
        tribo_q31_count(&state->bad_inputs);
    }
    feedforward_q31_after(feedforward, friction, &memory->state, v, u, seen->controller.limited, inner);
    const int32_t F = feedforward_q31_outside(sum_q31(inner->reached, tribo_arm_q31_force(&memory->state.path.arm)));
    seen->compensator =
        (tribo_compensator_q31_signals_t){.force    = F,
                                          .friction = {.n = tribo_q31_subtract(u, F, &not_counted),
                                                       .L = feedforward_q31_outside((int32_t)inner->ahead.L),
                                                       .f = feedforward_q31_outside(inner->f)}};
    return u;
}

/// With what was added in the last tick, and y expected as of then.
static int32_t wanted(const tribo_force_loop_q31_params_t *params,
                      tribo_force_loop_q31_state_t        *state,
                      int32_t                              r,
                      int32_t                              y)
{
    const tribo_feedforward_q31_memory_t *const memory = force_loop_q31_memory(state);

    uint32_t not_counted = 0;
    int32_t  e           = force_loop_q31_error(params, r, y, &not_counted);
    int32_t  added       = 0;
    if (memory != NULL)
    {
        added = memory->signals.added;
        if (!force_loop_q31_bad(params, r, y))
        {
            const int64_t moved = (int64_t)y - 4 * (int64_t)memory->signals.y;
            e                   = tribo_q31_saturate(memory->signals.e - moved, &not_counted);
        }
    }
    return tribo_q31_add(force_loop_q31_v(&params->controller, &state->controller, e), added, &not_counted);
}

const tribo_force_loop_q31_method_t tribo_force_loop_feedforward_q31 = {.step      = step,
                                                                        .wanted    = wanted,
                                                                        .hand_over = tribo_force_loop_q31_hand_over};
