#include "compensator_f32.h"

#include "tribo/friction_f32.h"

#include <stddef.h>

tribo_status_t tribo_compensator_f32_init(tribo_compensator_f32_params_t       *params,
                                          const tribo_compensator_f32_config_t *config,
                                          float                                 sample_time_s)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_compensator_f32_params_t made   = {.model = NULL};
    tribo_status_t                 status = tribo_friction_f32_init(&made.friction, &config->friction, sample_time_s);
    if (status == TRIBO_OK)
    {
        status = tribo_arm_f32_init(&made.arm, &config->arm, sample_time_s);
    }
    if (status == TRIBO_OK)
    {
        *params = made;
    }
    return status;
}

void tribo_compensator_f32_reset(tribo_compensator_f32_state_t *state)
{
    tribo_friction_f32_reset(&state->friction.paper);
    tribo_arm_f32_reset(&state->arm);
}

float tribo_compensator_f32_step(const tribo_compensator_f32_params_t *params,
                                 tribo_compensator_f32_state_t        *state,
                                 float                                 u_n,
                                 tribo_compensator_f32_signals_t      *signals)
{
    if (exceeds(state->arm.force_n, TRIBO_F32_FORCE_MAX_N)) // corrupt: no step leaves such a value
    {
        tribo_arm_f32_reset(&state->arm);
    }
    float n = compensator_f32_net_force(params, state, u_n);
    if (exceeds(u_n, TRIBO_F32_FORCE_MAX_N))
    {
        n = state->friction.paper.n_n;
        count(&state->friction.paper.bad_inputs);
    }
    return compensator_f32_step(params, state, n, signals);
}

float tribo_compensator_f32_model_step(const tribo_compensator_f32_params_t *params,
                                       tribo_compensator_f32_state_t        *state,
                                       float                                 n_n,
                                       tribo_compensator_f32_signals_t      *signals)
{
    const float F    = state->arm.force_n;
    signals->force_n = F;
    const float f = params->model->step(params->model, &params->friction, &state->friction, n_n, F, &signals->friction);
    arm_f32_step(&params->arm, &state->arm, n_n - f);
    return f;
}

float tribo_compensator_f32_peek(const tribo_compensator_f32_params_t *params,
                                 tribo_compensator_f32_state_t        *state,
                                 float                                 u_n)
{
    tribo_friction_f32_signals_t unseen;
    const float                  F = state->arm.force_n;
    if (params->model != NULL)
    {
        tribo_compensator_friction_f32_state_t copy = state->friction;

        const float n = compensator_f32_net_force(params, state, u_n);
        return params->model->step(params->model, &params->friction, &copy, n, F, &unseen);
    }
    tribo_friction_f32_state_t *const friction   = &state->friction.paper;
    const relay_snapshot_t            relay      = relay_snapshot(&friction->relay);
    const float                       n_before   = friction->n_n;
    const uint32_t                    bad_inputs = friction->bad_inputs;

    const float f = tribo_friction_f32_step(&params->friction, friction, u_n, F, &unseen);

    relay_restore(&friction->relay, relay);
    friction->n_n        = n_before;
    friction->bad_inputs = bad_inputs;
    return f;
}

float tribo_compensator_f32_enter(const tribo_compensator_f32_params_t *params,
                                  tribo_compensator_f32_state_t        *state,
                                  float                                 u_n,
                                  float                                 force_n)
{
    tribo_compensator_f32_reset(state);
    state->arm.force_n = force_n;
    const float n      = compensator_f32_net_force(params, state, u_n);
    if (params->model != NULL)
    {
        return params->model->enter(params->model, &params->friction, &state->friction, n, force_n);
    }
    state->friction.paper.n_n = n;
    return tribo_compensator_f32_peek(params, state, u_n);
}
