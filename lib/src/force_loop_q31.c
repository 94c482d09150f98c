#include "tribo/force_loop_q31.h"

#include "compensator_q31_step.h"
#include "controller_q31_step.h"
#include "fixed_q31.h"
#include "force_loop_q31_step.h"
#include "relay_step.h"
#include "tribo/quantize_q31.h"

tribo_status_t tribo_force_loop_q31_init(tribo_force_loop_q31_params_t       *params,
                                         tribo_breakaway_point_q31_t         *table,
                                         const tribo_force_loop_f32_config_t *config,
                                         float                                full_scale_n,
                                         tribo_headroom_q31_t                *headroom)
{
    tribo_force_loop_f32_params_t f32;
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_status_t status = tribo_force_loop_f32_init(&f32, config);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!full_scale_ok(full_scale_n))
    {
        return TRIBO_ERR_FULL_SCALE;
    }
    if (!within(config->input_max_n / full_scale_n, FIXED_Q31_SMALLEST, 1.0f))
    {
        return TRIBO_ERR_INPUT_MAX;
    }
    tribo_headroom_q31_t          measured;
    tribo_force_loop_q31_params_t made = {.input_max = fixed_force(config->input_max_n, full_scale_n),
                                          .gain      = fixed(f32.gain, FORCE_LOOP_Q31_GAIN_FRACTION)};

    status = tribo_controller_q31_init(&made.controller, &config->controller, full_scale_n, &measured);
    status = status != TRIBO_OK ? status
                                : tribo_compensator_q31_init(&made.compensator,
                                                             table,
                                                             &config->compensator,
                                                             config->sample_time_s,
                                                             full_scale_n);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (headroom != NULL)
    {
        *headroom = measured;
    }
    *params = made;
    return TRIBO_OK;
}

void tribo_force_loop_q31_reset(tribo_force_loop_q31_state_t *state)
{
    force_loop_q31_activate(state, NULL);
    force_loop_q31_attach(state, NULL);
    state->friction   = 0;
    state->bad_inputs = 0;
    state->saturated  = 0;
    tribo_controller_q31_reset(&state->controller);
    tribo_compensator_q31_reset(&state->compensator);
}

/// The friction term of u, gain f: Q29 x Q31, rounded down to Q31.
static int32_t feedforward_of(const tribo_force_loop_q31_params_t *params, int32_t f, uint32_t *saturated)
{
    return tribo_q31_narrow(tribo_q31_multiply(params->gain, f), FORCE_LOOP_Q31_GAIN_FRACTION, saturated);
}

/// The f^ that `params` would give in this tick: a step of the compensator whose effect on the state is undone. `signals` is
/// scratch.
static int32_t friction_under(const tribo_force_loop_q31_params_t *params,
                              tribo_compensator_q31_state_t       *state,
                              int32_t                              u,
                              tribo_compensator_q31_signals_t     *signals)
{
    tribo_friction_q31_state_t *const friction  = &state->friction.paper;
    const relay_snapshot_t            relay     = relay_snapshot(&friction->relay);
    const int32_t                     n_before  = friction->n;
    const uint32_t                    saturated = friction->saturated;
    const tribo_arm_q31_state_t       arm       = state->arm;

    const int32_t f = tribo_compensator_q31_step(&params->compensator, state, u, signals);

    state->arm = arm;
    relay_restore(&friction->relay, relay);
    friction->n         = n_before;
    friction->saturated = saturated;
    return f;
}

/// Converts the controller's state to the params `to` and subtracts `jump`, the change of the friction term of u.
static void change_controller(const tribo_force_loop_q31_params_t *from,
                              const tribo_force_loop_q31_params_t *to,
                              tribo_force_loop_q31_state_t        *state,
                              int32_t                              e,
                              int64_t                              jump)
{
    uint32_t      not_counted = 0;
    const int32_t offset      = tribo_q31_saturate(-jump, &not_counted);
    tribo_controller_q31_change(&from->controller, &to->controller, &state->controller, e, offset);
}

int32_t tribo_force_loop_q31_wanted(const tribo_force_loop_q31_params_t *from,
                                    tribo_force_loop_q31_state_t        *state,
                                    int32_t                              r,
                                    int32_t                              y)
{
    uint32_t not_counted = 0;
    if (from->method != NULL)
    {
        return from->method->wanted(from, state, r, y);
    }
    const int32_t e = force_loop_q31_error(from, r, y, &not_counted);
    return tribo_q31_add(force_loop_q31_v(&from->controller, &state->controller, e),
                         feedforward_of(from, state->friction, &not_counted),
                         &not_counted);
}

// The compensator starts where the sensor says that the arm is, and friction is what holds it there.
void tribo_force_loop_q31_hand_over(const tribo_force_loop_q31_params_t *from,
                                    const tribo_force_loop_q31_params_t *params,
                                    tribo_force_loop_q31_state_t        *state,
                                    int32_t                              r,
                                    int32_t                              y,
                                    int32_t                              e)
{
    tribo_compensator_q31_state_t *const compensator = &state->compensator;
    tribo_compensator_q31_signals_t      unseen;
    uint32_t                             not_counted = 0;

    const int32_t wanted = tribo_force_loop_q31_wanted(from, state, r, y);
    const int32_t u      = limit_q31(wanted, params->controller.u_min, params->controller.u_max);
    const int32_t F      = force_loop_q31_exceeds(y, params->input_max) ? u : y;
    tribo_compensator_q31_reset(compensator);
    compensator->arm.force = (int64_t)F * (INT64_C(1) << ARM_Q31_FRACTION);
    compensator->friction.paper.n =
        tribo_q31_saturate((int64_t)u - F + params->compensator.friction.gravity, &not_counted);
    state->friction = force_loop_q31_left(state, friction_under(params, compensator, u, &unseen));

    const int32_t v     = force_loop_q31_v(&from->controller, &state->controller, e);
    const int64_t added = feedforward_of(params, state->friction, &not_counted);
    change_controller(from, params, state, e, v + added - wanted);
}

/// Before the controller's step: converts its state to the new params and subtracts the jump by which a new gain or method would
/// move u in this tick. After a reset there is nothing to convert.
static void change_gain(const tribo_force_loop_q31_params_t *params,
                        tribo_force_loop_q31_state_t        *state,
                        int32_t                              r,
                        int32_t                              y,
                        int32_t                              e)
{
    const tribo_force_loop_q31_params_t *const from        = force_loop_q31_active(state, params);
    uint32_t                                   not_counted = 0;
    if (from->method != NULL)
    {
        from->method->hand_over(from, params, state, r, y, e);
    }
    else if (from != params)
    {
        const int64_t was = feedforward_of(from, state->friction, &not_counted);
        change_controller(from, params, state, e, feedforward_of(params, state->friction, &not_counted) - was);
    }
    else
    {
        force_loop_q31_activate(state, params);
    }
}

/// Before the compensator's step: the controller subtracts the jump by which a new friction model would move u from the next
/// tick on.
static void change_friction(const tribo_force_loop_q31_params_t *params,
                            tribo_force_loop_q31_state_t        *state,
                            int32_t                              e,
                            int32_t                              u,
                            tribo_compensator_q31_signals_t     *signals)
{
    const tribo_force_loop_q31_params_t *const from        = force_loop_q31_active(state, params);
    uint32_t                                   not_counted = 0;
    if (from->method == NULL)
    {
        const int32_t f_before = friction_under(from, &state->compensator, u, signals);
        const int32_t f        = friction_under(params, &state->compensator, u, signals);
        const int64_t was      = feedforward_of(params, f_before, &not_counted);
        change_controller(params, params, state, e, feedforward_of(params, f, &not_counted) - was);
    }
    force_loop_q31_activate(state, params);
}

int32_t tribo_force_loop_q31_step(const tribo_force_loop_q31_params_t *params,
                                  tribo_force_loop_q31_state_t        *state,
                                  int32_t                              r,
                                  int32_t                              y,
                                  tribo_force_loop_q31_signals_t      *signals)
{
    if (params->method != NULL)
    {
        return params->method->step(params, state, r, y, signals);
    }
    tribo_force_loop_q31_signals_t        unseen;
    tribo_force_loop_q31_signals_t *const seen = signals != NULL ? signals : &unseen; // cppcheck-suppress uninitvar

    int32_t e = 0; // for a bad input: u coasts on the controller's state
    if (force_loop_q31_bad(params, r, y))
    {
        tribo_q31_count(&state->bad_inputs);
    }
    else
    {
        e = tribo_q31_subtract(r, y, &state->saturated);
    }

    if (state->active != params)
    {
        change_gain(params, state, r, y, e);
    }

    const int32_t feedforward = feedforward_of(params, state->friction, &state->saturated);
    seen->e                   = e;
    seen->feedforward         = feedforward;

    const int32_t u = controller_q31_step(&params->controller, &state->controller, e, feedforward, &seen->controller);

    if (state->active != params)
    {
        change_friction(params, state, seen->e, u, &seen->compensator);
    }
    state->friction = tribo_compensator_q31_step(&params->compensator, &state->compensator, u, &seen->compensator);
    return u;
}
