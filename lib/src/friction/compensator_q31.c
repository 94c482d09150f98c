#include "compensator_q31.h"

#include "tribo/friction_f32.h"

#include "compensator_f32.h"

#include <stddef.h>

tribo_status_t tribo_compensator_q31_init(tribo_compensator_q31_params_t       *params,
                                          tribo_breakaway_point_q31_t          *table,
                                          const tribo_compensator_f32_config_t *config,
                                          float                                 sample_time_s,
                                          float                                 full_scale_n)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    // The arm first: the friction, when it is accepted, writes the table.
    tribo_compensator_q31_params_t made = {.model = NULL};
    tribo_compensator_f32_params_t f32;
    tribo_status_t                 status = tribo_compensator_f32_init(&f32, config, sample_time_s);
    status = status != TRIBO_OK ? status : tribo_arm_q31_init(&made.arm, &config->arm, sample_time_s);
    status = status != TRIBO_OK
                 ? status
                 : tribo_friction_q31_init(&made.friction, table, &config->friction, sample_time_s, full_scale_n);
    if (status == TRIBO_OK)
    {
        *params = made;
    }
    return status;
}

void tribo_compensator_q31_reset(tribo_compensator_q31_state_t *state)
{
    tribo_friction_q31_reset(&state->friction.paper);
    tribo_arm_q31_reset(&state->arm);
}

int32_t tribo_compensator_q31_step(const tribo_compensator_q31_params_t *params,
                                   tribo_compensator_q31_state_t        *state,
                                   int32_t                               u,
                                   tribo_compensator_q31_signals_t      *signals)
{
    return compensator_q31_step(params, state, u, signals);
}

int32_t tribo_compensator_q31_model_step(const tribo_compensator_q31_params_t *params,
                                         tribo_compensator_q31_state_t        *state,
                                         int32_t                               u,
                                         tribo_compensator_q31_signals_t      *signals)
{
    const int32_t F = tribo_arm_q31_force(&state->arm);
    signals->force  = F;
    const int32_t n = friction_q31_net_force(&params->friction, &state->friction.paper, u, F);
    const int32_t f = params->model->step(params->model, &params->friction, &state->friction, n, F, &signals->friction);
    // The drive d = n - f^. While the arm slides back the two may differ in sign, and d may be beyond full scale.
    arm_q31_step(&params->arm, &state->arm, tribo_q31_subtract(n, f, &state->friction.paper.saturated));
    return f;
}

int32_t tribo_compensator_q31_peek(const tribo_compensator_q31_params_t *params,
                                   tribo_compensator_q31_state_t        *state,
                                   int32_t                               u)
{
    tribo_friction_q31_signals_t unseen;
    const int32_t                F = tribo_arm_q31_force(&state->arm);
    if (params->model != NULL)
    {
        tribo_compensator_friction_q31_state_t copy = state->friction;

        const int32_t n = friction_q31_net_force(&params->friction, &copy.paper, u, F);
        return params->model->step(params->model, &params->friction, &copy, n, F, &unseen);
    }
    tribo_friction_q31_state_t *const friction  = &state->friction.paper;
    const relay_snapshot_t            relay     = relay_snapshot(&friction->relay);
    const int32_t                     n_before  = friction->n;
    const uint32_t                    saturated = friction->saturated;

    const int32_t f = tribo_friction_q31_step(&params->friction, friction, u, F, &unseen);

    relay_restore(&friction->relay, relay);
    friction->n         = n_before;
    friction->saturated = saturated;
    return f;
}

int32_t tribo_compensator_q31_enter(const tribo_compensator_q31_params_t *params,
                                    tribo_compensator_q31_state_t        *state,
                                    int32_t                               u,
                                    int32_t                               force)
{
    uint32_t not_counted = 0;
    tribo_compensator_q31_reset(state);
    state->arm.force = (int64_t)force * (INT64_C(1) << ARM_Q31_FRACTION);
    const int32_t n  = tribo_q31_saturate((int64_t)u - force + params->friction.gravity, &not_counted);
    if (params->model != NULL)
    {
        return params->model->enter(params->model, &params->friction, &state->friction, n, force);
    }
    state->friction.paper.n = n;
    return tribo_compensator_q31_peek(params, state, u);
}
