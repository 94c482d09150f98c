#include "tribo/feedforward_q31.h"

#include "tribo/feedforward_f32.h"

#include "feedforward_q31.h"

#include <stddef.h>

// One by one: an initialiser would be a table of absolute addresses.
static void set_functions(tribo_force_loop_q31_method_t *method)
{
    method->error    = tribo_feedforward_q31_method_error;
    method->friction = tribo_feedforward_q31_method_friction;
    method->term     = tribo_feedforward_q31_method_term;
    method->after    = tribo_feedforward_q31_method_after;
    method->last     = tribo_feedforward_q31_method_last;
    method->enter    = tribo_feedforward_q31_method_enter;
}

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
    *params = made;
    set_functions(&feedforward->method);
    params->method = &feedforward->method;
    return TRIBO_OK;
}

void tribo_force_loop_feedforward_q31_attach(tribo_force_loop_q31_state_t   *state,
                                             tribo_feedforward_q31_memory_t *memory)
{
    state->memory      = memory;
    state->memory_seal = ~(uintptr_t)memory;
    if (memory != NULL)
    {
        memory->signals = (tribo_feedforward_q31_signals_t){.e = 0};
        tribo_feedforward_q31_restart(&memory->state);
    }
}

/// The params of which `params->method` is the first member.
static const tribo_feedforward_q31_params_t *own(const tribo_force_loop_q31_params_t *params)
{
    return (const tribo_feedforward_q31_params_t *)params->method;
}

int32_t tribo_feedforward_q31_method_error(const tribo_force_loop_q31_params_t *params,
                                           void                                *memory,
                                           int32_t                              r,
                                           int32_t                              y,
                                           uint32_t                             fade)
{
    tribo_feedforward_q31_memory_t *const inner = memory;

    inner->state.fade = fade;
    return feedforward_q31_before(own(params), &params->compensator.friction, &inner->state, r, y, &inner->signals);
}

int32_t tribo_feedforward_q31_method_friction(const void *memory)
{
    return feedforward_q31_outside(((const tribo_feedforward_q31_memory_t *)memory)->state.f);
}

int32_t tribo_feedforward_q31_method_term(const tribo_force_loop_q31_params_t *params, void *memory, int32_t v)
{
    tribo_feedforward_q31_memory_t *const inner = memory;
    return feedforward_q31_added(own(params), &inner->state, v, &inner->signals);
}

void tribo_feedforward_q31_method_after(const tribo_force_loop_q31_params_t *params,
                                        void                                *memory,
                                        int32_t                              v,
                                        int32_t                              u,
                                        tribo_force_loop_q31_signals_t      *signals)
{
    tribo_feedforward_q31_memory_t *const  inner       = memory;
    tribo_feedforward_q31_signals_t *const seen        = &inner->signals;
    uint32_t                               not_counted = 0;
    feedforward_q31_after(own(params),
                          &params->compensator.friction,
                          &inner->state,
                          v,
                          u,
                          signals->controller.limited,
                          seen);
    const int32_t F =
        feedforward_q31_outside(sum_q31(seen->reached, tribo_arm_q31_force(&inner->state.reference_model.arm)));
    const int32_t f = feedforward_q31_outside(seen->f);
    signals->compensator =
        (tribo_compensator_q31_signals_t){.force    = F,
                                          .friction = {.n = tribo_q31_subtract(u, F, &not_counted),
                                                       .L = feedforward_q31_outside((int32_t)seen->ahead.L),
                                                       .f = f}};
}

void tribo_feedforward_q31_method_last(const void *memory, tribo_force_loop_q31_last_t *last)
{
    const tribo_feedforward_q31_state_t *const state = &((const tribo_feedforward_q31_memory_t *)memory)->state;
    if (state->running)
    {
        last->e    = state->e;
        last->y    = (int32_t)(4u * (uint32_t)state->y);
        last->term = state->added;
    }
}

void tribo_feedforward_q31_method_enter(void *memory, int32_t term, bool anew)
{
    tribo_feedforward_q31_state_t *const state = &((tribo_feedforward_q31_memory_t *)memory)->state;
    if (anew)
    {
        tribo_feedforward_q31_enter(state, term);
    }
    else
    {
        state->entering = state->running;
        state->entry    = term;
    }
}
