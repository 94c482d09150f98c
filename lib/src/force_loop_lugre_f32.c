#include "tribo/force_loop_lugre_f32.h"

#include "compensator_f32_step.h"
#include "controller_f32_step.h"
#include "force_loop_f32_step.h"
#include "lugre_f32_step.h"
#include "tribo/compensator_lugre_f32.h"

#include <stddef.h>

tribo_status_t tribo_force_loop_lugre_f32_init(tribo_force_loop_f32_params_t       *params,
                                               tribo_lugre_f32_params_t            *lugre,
                                               const tribo_force_loop_f32_config_t *config,
                                               const tribo_lugre_f32_config_t      *lugre_config)
{
    tribo_force_loop_f32_params_t made;
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_status_t status = tribo_force_loop_f32_init(&made, config);
    if (status == TRIBO_OK)
    {
        status = tribo_lugre_f32_init(lugre, lugre_config, &config->compensator.arm, config->sample_time_s);
    }
    if (status == TRIBO_OK)
    {
        made.method = &tribo_force_loop_lugre_f32;
        made.lugre  = lugre;
        *params     = made;
    }
    return status;
}

/// The f^ that `params` would give in this tick; nothing advances.
static float friction_under(const tribo_force_loop_f32_params_t *params,
                            const tribo_compensator_f32_state_t *state,
                            float                                u_n)
{
    tribo_compensator_f32_state_t   copy = *state;
    tribo_compensator_f32_signals_t unseen;
    return tribo_compensator_lugre_f32_step(&params->compensator, params->lugre, &copy, u_n, &unseen);
}

/// Takes over from another method, in front of the controller's step. The compensator starts where the sensor says that the arm
/// is, and the bristles hold it there: f^ = Z = n, at most L.
static void enter(const tribo_force_loop_f32_params_t *from,
                  const tribo_force_loop_f32_params_t *params,
                  tribo_force_loop_f32_state_t        *state,
                  float                                r_n,
                  float                                y_n,
                  float                                e)
{
    tribo_compensator_f32_state_t *const compensator = &state->compensator;

    const float wanted = tribo_force_loop_f32_wanted(from, state, r_n, y_n);
    const float u      = limit_f32(wanted, params->controller.u_min_n, params->controller.u_max_n);
    float       L[2];
    tribo_compensator_lugre_f32_reset(compensator);
    compensator->arm.force_n = exceeds(y_n, params->input_max_n) ? u : y_n;
    lugre_f32_breakaway(&params->compensator.friction, compensator->arm.force_n, L);
    const float f = limit_f32(compensator_f32_net_force(&params->compensator, compensator, u), -L[1], L[0]);
    compensator->friction.lugre.bristle_n = f;
    state->friction_n                     = force_loop_f32_left(state, f);

    const float v = force_loop_f32_v(&from->controller, &state->controller, e);
    tribo_controller_f32_change(&from->controller,
                                &params->controller,
                                &state->controller,
                                e,
                                wanted - params->gain * state->friction_n - v);
}

/// In front of the controller's step: takes over from the params of the last tick.
static void change_controller(const tribo_force_loop_f32_params_t *params,
                              tribo_force_loop_f32_state_t        *state,
                              float                                r_n,
                              float                                y_n,
                              float                                e)
{
    const tribo_force_loop_f32_params_t *const from = force_loop_f32_active(state, params);
    if (from->method != params->method)
    {
        enter(from, params, state, r_n, y_n, e);
        force_loop_f32_activate(state, params);
    }
    else if (from != params)
    {
        const float jump = (params->gain - from->gain) * state->friction_n;
        tribo_controller_f32_change(&from->controller, &params->controller, &state->controller, e, -jump);
    }
    else if (state->active == NULL) // the reset was that of the paper's friction
    {
        tribo_lugre_f32_reset(&state->compensator.friction.lugre);
    }
}

/// Before the compensator's step: the controller subtracts the jump by which other bristles would move u from the next tick on.
static void change_friction(const tribo_force_loop_f32_params_t *params,
                            tribo_force_loop_f32_state_t        *state,
                            float                                e,
                            float                                u)
{
    const tribo_force_loop_f32_params_t *const from = force_loop_f32_active(state, params);
    if (from != params)
    {
        const float was  = friction_under(from, &state->compensator, u);
        const float jump = params->gain * (friction_under(params, &state->compensator, u) - was);
        tribo_controller_f32_change(&params->controller, &params->controller, &state->controller, e, -jump);
    }
    force_loop_f32_activate(state, params);
}

static float step(const tribo_force_loop_f32_params_t *params,
                  tribo_force_loop_f32_state_t        *state,
                  float                                r_n,
                  float                                y_n,
                  tribo_force_loop_f32_signals_t      *signals)
{
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

    state->friction_n = tribo_compensator_lugre_f32_step(&params->compensator,
                                                         params->lugre,
                                                         &state->compensator,
                                                         u,
                                                         &seen->compensator);
    return u;
}

const tribo_force_loop_f32_method_t tribo_force_loop_lugre_f32 = {.step      = step,
                                                                  .wanted    = force_loop_f32_fed_back,
                                                                  .hand_over = tribo_force_loop_f32_hand_over};
