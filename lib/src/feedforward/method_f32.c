#include "tribo/feedforward_f32.h"

#include "feedforward_f32.h"

#include <stddef.h>

// Beyond any sum of credible forces, or any relative variance: the memory is corrupt.
#define FORCE_MAX_N           1.0e9f
#define RELATIVE_VARIANCE_MAX 2.0f

// One by one: an initialiser would be a table of absolute addresses.
static void set_functions(tribo_force_loop_f32_method_t *method)
{
    method->error    = tribo_feedforward_f32_method_error;
    method->friction = tribo_feedforward_f32_method_friction;
    method->term     = tribo_feedforward_f32_method_term;
    method->after    = tribo_feedforward_f32_method_after;
    method->last     = tribo_feedforward_f32_method_last;
    method->enter    = tribo_feedforward_f32_method_enter;
}

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
        *params = made;
        set_functions(&feedforward->method);
        params->method = &feedforward->method;
    }
    return status;
}

void tribo_force_loop_feedforward_f32_attach(tribo_force_loop_f32_state_t   *state,
                                             tribo_feedforward_f32_memory_t *memory)
{
    state->memory      = memory;
    state->memory_seal = ~(uintptr_t)memory;
    if (memory != NULL)
    {
        memory->signals = (tribo_feedforward_f32_signals_t){.e_n = 0.0f};
        tribo_feedforward_f32_restart(&memory->state);
    }
}

/// The params of which `params->method` is the first member.
static const tribo_feedforward_f32_params_t *own(const tribo_force_loop_f32_params_t *params)
{
    return (const tribo_feedforward_f32_params_t *)params->method;
}

// With a corrupt memory the controller alone runs with r - y; state.running is then 0 for the rest of the tick.
float tribo_feedforward_f32_method_error(const tribo_force_loop_f32_params_t *params,
                                         void                                *memory,
                                         float                                r_n,
                                         float                                y_n,
                                         float                                fade)
{
    tribo_feedforward_f32_memory_t *const  inner   = memory;
    tribo_feedforward_f32_signals_t *const signals = &inner->signals;

    inner->state.fade = fade;
    const float e =
        feedforward_f32_before(own(params), &params->compensator.friction, &inner->state, r_n, y_n, signals);
    if (exceeds(e, FORCE_MAX_N) || exceeds(signals->lin_n + signals->f_n, FORCE_MAX_N) ||
        exceeds(signals->ahead.relative_variance, RELATIVE_VARIANCE_MAX))
    {
        tribo_feedforward_f32_reset(own(params), &inner->state);
        return signals->r_good && signals->y_good ? r_n - y_n : 0.0f;
    }
    return e;
}

float tribo_feedforward_f32_method_friction(const void *memory)
{
    const tribo_feedforward_f32_state_t *const state = &((const tribo_feedforward_f32_memory_t *)memory)->state;
    return state->running ? state->f_n : 0.0f;
}

float tribo_feedforward_f32_method_term(const tribo_force_loop_f32_params_t *params, void *memory, float v_n)
{
    tribo_feedforward_f32_memory_t *const inner = memory;
    return inner->state.running ? feedforward_f32_added(own(params), &inner->state, v_n, &inner->signals) : 0.0f;
}

void tribo_feedforward_f32_method_after(const tribo_force_loop_f32_params_t *params,
                                        void                                *memory,
                                        float                                v_n,
                                        float                                u_n,
                                        tribo_force_loop_f32_signals_t      *signals)
{
    tribo_feedforward_f32_memory_t *const  inner = memory;
    tribo_feedforward_f32_signals_t *const seen  = &inner->signals;
    if (!inner->state.running)
    {
        return;
    }
    feedforward_f32_after(own(params),
                          &params->compensator.friction,
                          &inner->state,
                          v_n,
                          u_n,
                          signals->controller.limited,
                          seen);
    const float F = seen->reached_n + inner->state.reference_model.arm.force_n;
    signals->compensator =
        (tribo_compensator_f32_signals_t){.force_n  = F,
                                          .friction = {.n_n = u_n - F, .L_n = seen->ahead.L_n, .f_n = seen->f_n}};
}

void tribo_feedforward_f32_method_last(const void *memory, tribo_force_loop_f32_last_t *last)
{
    const tribo_feedforward_f32_state_t *const state = &((const tribo_feedforward_f32_memory_t *)memory)->state;
    if (state->running)
    {
        last->e_n    = state->e_n;
        last->y_n    = state->observer.y_n;
        last->term_n = state->added_n;
    }
}

void tribo_feedforward_f32_method_enter(void *memory, float term_n, bool anew)
{
    tribo_feedforward_f32_state_t *const state = &((tribo_feedforward_f32_memory_t *)memory)->state;
    if (anew)
    {
        tribo_feedforward_f32_enter(state, term_n);
    }
    else
    {
        state->entering = state->running;
        state->entry_n  = term_n;
    }
}
