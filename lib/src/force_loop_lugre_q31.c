#include "tribo/force_loop_lugre_q31.h"

#include "compensator_q31_step.h"
#include "controller_q31_step.h"
#include "force_loop_q31_step.h"
#include "lugre_q31_step.h"
#include "tribo/compensator_lugre_q31.h"
#include "tribo/quantize_q31.h"

#include <stddef.h>

tribo_status_t tribo_force_loop_lugre_q31_init(tribo_force_loop_q31_params_t       *params,
                                               tribo_breakaway_point_q31_t         *table,
                                               tribo_lugre_q31_params_t            *lugre,
                                               const tribo_force_loop_f32_config_t *config,
                                               const tribo_lugre_f32_config_t      *lugre_config,
                                               float                                full_scale_n,
                                               tribo_headroom_q31_t                *headroom)
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
        status = tribo_lugre_q31_init(lugre, lugre_config, &config->compensator.arm, config->sample_time_s);
    }
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (headroom != NULL)
    {
        *headroom = measured;
    }
    made.method = &tribo_force_loop_lugre_q31;
    made.lugre  = lugre;
    *params     = made;
    return TRIBO_OK;
}

/// The friction term of u, gain f: Q29 x Q31, rounded down to Q31.
static int32_t feedforward_of(const tribo_force_loop_q31_params_t *params, int32_t f, uint32_t *saturated)
{
    return tribo_q31_narrow(tribo_q31_multiply(params->gain, f), FORCE_LOOP_Q31_GAIN_FRACTION, saturated);
}

/// The f^ that `params` would give in this tick; nothing advances.
static int32_t friction_under(const tribo_force_loop_q31_params_t *params,
                              const tribo_compensator_q31_state_t *state,
                              int32_t                              u)
{
    tribo_compensator_q31_state_t   copy = *state;
    tribo_compensator_q31_signals_t unseen;
    return tribo_compensator_lugre_q31_step(&params->compensator, params->lugre, &copy, u, &unseen);
}

/// Converts the controller's state to the params `to` and subtracts `jump`, the change of the friction term of u.
static void change_by(const tribo_force_loop_q31_params_t *from,
                      const tribo_force_loop_q31_params_t *to,
                      tribo_force_loop_q31_state_t        *state,
                      int32_t                              e,
                      int64_t                              jump)
{
    uint32_t      not_counted = 0;
    const int32_t offset      = tribo_q31_saturate(-jump, &not_counted);
    tribo_controller_q31_change(&from->controller, &to->controller, &state->controller, e, offset);
}

/// Takes over from another method, in front of the controller's step. The compensator starts where the sensor says that the arm
/// is, and the bristles hold it there: f^ = Z = n, at most L.
static void enter(const tribo_force_loop_q31_params_t *from,
                  const tribo_force_loop_q31_params_t *params,
                  tribo_force_loop_q31_state_t        *state,
                  int32_t                              r,
                  int32_t                              y,
                  int32_t                              e)
{
    tribo_compensator_q31_state_t *const compensator = &state->compensator;
    uint32_t                             not_counted = 0;

    const int32_t wanted = tribo_force_loop_q31_wanted(from, state, r, y);
    const int32_t u      = limit_q31(wanted, params->controller.u_min, params->controller.u_max);
    const int32_t F      = force_loop_q31_exceeds(y, params->input_max) ? u : y;
    int32_t       L[2];
    tribo_compensator_lugre_q31_reset(compensator);
    compensator->arm.force = (int64_t)F * (INT64_C(1) << ARM_Q31_FRACTION);
    lugre_q31_breakaway(&params->compensator.friction, F, L);
    const int32_t n = tribo_q31_saturate((int64_t)u - F + params->compensator.friction.gravity, &not_counted);
    const int32_t f = limit_q31(n, -L[1], L[0]);

    compensator->friction.lugre.bristle = f;
    state->friction                     = force_loop_q31_left(state, f);

    const int64_t v = force_loop_q31_v(&from->controller, &state->controller, e);
    change_by(from, params, state, e, v + feedforward_of(params, state->friction, &not_counted) - wanted);
}

/// In front of the controller's step: takes over from the params of the last tick.
static void change_controller(const tribo_force_loop_q31_params_t *params,
                              tribo_force_loop_q31_state_t        *state,
                              int32_t                              r,
                              int32_t                              y,
                              int32_t                              e)
{
    const tribo_force_loop_q31_params_t *const from        = force_loop_q31_active(state, params);
    uint32_t                                   not_counted = 0;
    if (from->method != params->method)
    {
        enter(from, params, state, r, y, e);
        force_loop_q31_activate(state, params);
    }
    else if (from != params)
    {
        const int64_t was = feedforward_of(from, state->friction, &not_counted);
        change_by(from, params, state, e, feedforward_of(params, state->friction, &not_counted) - was);
    }
    else if (state->active == NULL) // the reset was that of the paper's friction
    {
        tribo_lugre_q31_reset(&state->compensator.friction.lugre);
    }
}

/// Before the compensator's step: the controller subtracts the jump by which other bristles would move u from the next tick on.
static void change_friction(const tribo_force_loop_q31_params_t *params,
                            tribo_force_loop_q31_state_t        *state,
                            int32_t                              e,
                            int32_t                              u)
{
    const tribo_force_loop_q31_params_t *const from        = force_loop_q31_active(state, params);
    uint32_t                                   not_counted = 0;
    if (from != params)
    {
        const int64_t was = feedforward_of(params, friction_under(from, &state->compensator, u), &not_counted);
        const int64_t is  = feedforward_of(params, friction_under(params, &state->compensator, u), &not_counted);
        change_by(params, params, state, e, is - was);
    }
    force_loop_q31_activate(state, params);
}

static int32_t step(const tribo_force_loop_q31_params_t *params,
                    tribo_force_loop_q31_state_t        *state,
                    int32_t                              r,
                    int32_t                              y,
                    tribo_force_loop_q31_signals_t      *signals)
{
    tribo_force_loop_q31_signals_t        unseen;
    tribo_force_loop_q31_signals_t *const seen = signals != NULL ? signals : &unseen; // cppcheck-suppress uninitvar

    // With a bad input e is 0: u coasts on the controller's state.
    const int32_t e = force_loop_q31_error(params, r, y, &state->saturated);
    if (force_loop_q31_bad(params, r, y))
    {
        tribo_q31_count(&state->bad_inputs);
    }

    const bool change = state->active != params;
    if (change)
    {
        change_controller(params, state, r, y, e);
    }

    const int32_t feedforward = feedforward_of(params, state->friction, &state->saturated);
    seen->e                   = e;
    seen->feedforward         = feedforward;

    const int32_t u = controller_q31_step(&params->controller, &state->controller, e, feedforward, &seen->controller);

    if (change)
    {
        change_friction(params, state, e, u);
    }

    state->friction = tribo_compensator_lugre_q31_step(&params->compensator,
                                                       params->lugre,
                                                       &state->compensator,
                                                       u,
                                                       &seen->compensator);
    return u;
}

static int32_t wanted(const tribo_force_loop_q31_params_t *params,
                      tribo_force_loop_q31_state_t        *state,
                      int32_t                              r,
                      int32_t                              y)
{
    uint32_t      not_counted = 0;
    const int32_t e           = force_loop_q31_error(params, r, y, &not_counted);
    return tribo_q31_add(force_loop_q31_v(&params->controller, &state->controller, e),
                         feedforward_of(params, state->friction, &not_counted),
                         &not_counted);
}

const tribo_force_loop_q31_method_t tribo_force_loop_lugre_q31 = {.step      = step,
                                                                  .wanted    = wanted,
                                                                  .hand_over = tribo_force_loop_q31_hand_over};
