#include "tribo/force_loop_f32.h"

#include "compensator_f32_step.h"
#include "controller_f32_step.h"
#include "force_loop_f32_step.h"
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
    tribo_force_loop_f32_params_t made   = {.input_max_n = config->input_max_n, .gain = config->gain};
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

void tribo_force_loop_f32_reset(tribo_force_loop_f32_state_t *state)
{
    force_loop_f32_activate(state, NULL);
    force_loop_f32_attach(state, NULL);
    state->friction_n = 0.0f;
    state->bad_inputs = 0;
    tribo_controller_f32_reset(&state->controller);
    tribo_compensator_f32_reset(&state->compensator);
}

/// The f^ that `params` would give in this tick: a step of the friction model whose effect on the state is undone.
static float friction_under(const tribo_force_loop_f32_params_t *params,
                            tribo_compensator_f32_state_t       *state,
                            float                                u_n)
{
    tribo_friction_f32_state_t *const friction   = &state->friction.paper;
    const relay_snapshot_t            relay      = relay_snapshot(&friction->relay);
    const float                       n_before   = friction->n_n;
    const uint32_t                    bad_inputs = friction->bad_inputs;
    tribo_friction_f32_signals_t      unseen;

    const float f = tribo_friction_f32_step(&params->compensator.friction, friction, u_n, state->arm.force_n, &unseen);

    relay_restore(&friction->relay, relay);
    friction->n_n        = n_before;
    friction->bad_inputs = bad_inputs;
    return f;
}

float tribo_force_loop_f32_wanted(const tribo_force_loop_f32_params_t *from,
                                  tribo_force_loop_f32_state_t        *state,
                                  float                                r_n,
                                  float                                y_n)
{
    return from->method != NULL ? from->method->wanted(from, state, r_n, y_n)
                                : force_loop_f32_fed_back(from, state, r_n, y_n);
}

// The compensator starts where the sensor says that the arm is, and friction is what holds it there.
void tribo_force_loop_f32_hand_over(const tribo_force_loop_f32_params_t *from,
                                    const tribo_force_loop_f32_params_t *params,
                                    tribo_force_loop_f32_state_t        *state,
                                    float                                r_n,
                                    float                                y_n,
                                    float                                e)
{
    tribo_compensator_f32_state_t *const compensator = &state->compensator;

    const float wanted = tribo_force_loop_f32_wanted(from, state, r_n, y_n);
    const float u      = limit_f32(wanted, params->controller.u_min_n, params->controller.u_max_n);
    tribo_compensator_f32_reset(compensator);
    compensator->arm.force_n        = exceeds(y_n, params->input_max_n) ? u : y_n;
    compensator->friction.paper.n_n = compensator_f32_net_force(&params->compensator, compensator, u);
    state->friction_n               = force_loop_f32_left(state, friction_under(params, compensator, u));

    const float v     = force_loop_f32_v(&from->controller, &state->controller, e);
    const float added = params->gain * state->friction_n;
    tribo_controller_f32_change(&from->controller, &params->controller, &state->controller, e, wanted - added - v);
}

/// Before the controller's step: converts its state to the new params and subtracts the jump by which a new gain or method would
/// move u in this tick.
static void change_controller(const tribo_force_loop_f32_params_t *params,
                              tribo_force_loop_f32_state_t        *state,
                              float                                r_n,
                              float                                y_n,
                              float                                e)
{
    const tribo_force_loop_f32_params_t *const from = force_loop_f32_active(state, params);
    if (from->method != NULL)
    {
        from->method->hand_over(from, params, state, r_n, y_n, e);
    }
    else if (from != params)
    {
        const float jump = (params->gain - from->gain) * state->friction_n;
        tribo_controller_f32_change(&from->controller, &params->controller, &state->controller, e, -jump);
    }
}

/// Before the compensator's step: the controller subtracts the jump by which a new friction model would move u from the next
/// tick on.
static void change_friction(const tribo_force_loop_f32_params_t *params,
                            tribo_force_loop_f32_state_t        *state,
                            float                                e,
                            float                                u)
{
    const tribo_force_loop_f32_params_t *const from = force_loop_f32_active(state, params);
    if (from != params && from->method == NULL)
    {
        const float was  = friction_under(from, &state->compensator, u);
        const float jump = params->gain * (friction_under(params, &state->compensator, u) - was);
        tribo_controller_f32_change(&params->controller, &params->controller, &state->controller, e, -jump);
    }
    force_loop_f32_activate(state, params);
}

float tribo_force_loop_f32_step(const tribo_force_loop_f32_params_t *params,
                                tribo_force_loop_f32_state_t        *state,
                                float                                r_n,
                                float                                y_n,
                                tribo_force_loop_f32_signals_t      *signals)
{
    if (params->method != NULL)
    {
        return params->method->step(params, state, r_n, y_n, signals);
    }
    tribo_force_loop_f32_signals_t        unseen;
    tribo_force_loop_f32_signals_t *const seen = signals != NULL ? signals : &unseen; // cppcheck-suppress uninitvar

    float e = r_n - y_n;
    if (force_loop_f32_bad(params, r_n, y_n))
    {
        e = 0.0f; // u coasts on the controller's state
        count(&state->bad_inputs);
    }

    const bool change = state->active != params;
    if (change)
    {
        change_controller(params, state, r_n, y_n, e);
    }

    const float feedforward = params->gain * state->friction_n;
    seen->e_n               = e;
    seen->feedforward_n     = feedforward;

    const float u = controller_f32_step(&params->controller, &state->controller, e, feedforward, &seen->controller);

    if (change)
    {
        change_friction(params, state, e, u);
    }

    const float n     = compensator_f32_net_force(&params->compensator, &state->compensator, u);
    state->friction_n = compensator_f32_step(&params->compensator, &state->compensator, n, &seen->compensator);
    return u;
}
