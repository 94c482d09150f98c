// A change of params between two ticks. u continues from its value under the old params, even if gain, controller, friction and
// method have changed.

#include "tribo/force_loop_q31.h"

#include "../controller/anti_windup_q31.h"
#include "../friction/compensator_q31.h"
#include "../number/first_order_q31.h"
#include "loop_q31.h"

#include <stddef.h>

/// The params of the last tick; `params` after a reset or if the pointer is corrupt, which means no change.
static const tribo_force_loop_q31_params_t *active(const tribo_force_loop_q31_state_t  *state,
                                                   const tribo_force_loop_q31_params_t *params)
{
    const bool good = state->active != NULL && loop_sealed(state->active, state->active_seal);
    return good ? state->active : params;
}

/// The controller's output for `e`, within 32 bits; no state advances.
static int32_t output(const tribo_controller_q31_params_t *params, tribo_controller_q31_state_t *state, int32_t e)
{
    tribo_biquad_q31_outputs_t outputs;
    const uint32_t             carry       = state->cascade.carry;
    uint32_t                   not_counted = 0;
    const int32_t              y           = biquad_q31_output(&params->cascade, &state->cascade, e, &outputs);
    state->cascade.carry                   = carry;
    return tribo_q31_widen(y, params->cascade.output_scale, &not_counted);
}

/// Converts the controller's state to the params `to`, for the error `e`, and adds `offset` to its output.
static void convert(const tribo_force_loop_q31_params_t *from,
                    const tribo_force_loop_q31_params_t *to,
                    tribo_force_loop_q31_state_t        *state,
                    int32_t                              e,
                    int64_t                              offset)
{
    uint32_t not_counted = 0;
    tribo_controller_q31_change(&from->controller,
                                &to->controller,
                                &state->controller,
                                e,
                                tribo_q31_saturate(offset, &not_counted));
}

/// The last tick under the params `from`: of the method, or of a controller alone, with the error `e` and the reading `y` where the
/// method had no tick.
static tribo_force_loop_q31_tick_t last_of(const tribo_force_loop_q31_params_t *from,
                                           const tribo_force_loop_q31_state_t  *state,
                                           int32_t                              e,
                                           int32_t                              y)
{
    tribo_force_loop_q31_tick_t              last        = {.e = e, .y = y};
    const tribo_force_loop_q31_tick_t *const tick        = force_loop_q31_memory(state);
    uint32_t                                 not_counted = 0;
    if (from->method == NULL)
    {
        last.term = force_loop_q31_term(from, force_loop_q31_faded(from, state), &not_counted);
    }
    else if (tick != NULL)
    {
        last.e    = tick->has_e ? tick->e : e;
        last.y    = tick->has_e && tick->has_y ? tick->y : y;
        last.term = tick->term;
    }
    return last;
}

/// u of this tick under the params `from`, before its limit, within 32 bits.
static int32_t unsaturated(const tribo_force_loop_q31_params_t *from,
                           tribo_force_loop_q31_state_t        *state,
                           int32_t                              r,
                           int32_t                              y)
{
    uint32_t                          not_counted = 0;
    const tribo_force_loop_q31_tick_t last        = last_of(from, state, tribo_q31_subtract(r, y, &not_counted), y);
    // The last error with the change of y.
    const int32_t e =
        force_loop_q31_bad(from, r, y) ? 0 : tribo_q31_saturate((int64_t)last.e + last.y - y, &not_counted);
    return tribo_q31_add(output(&from->controller, &state->controller, e), last.term, &not_counted);
}

/// From another method or friction model to the compensator: it starts at the sensor's reading, with the friction that holds the
/// arm there.
static void enter_compensator(const tribo_force_loop_q31_params_t *from,
                              const tribo_force_loop_q31_params_t *params,
                              tribo_force_loop_q31_state_t        *state,
                              int32_t                              r,
                              int32_t                              y,
                              int32_t                              e)
{
    const int32_t going = unsaturated(from, state, r, y);
    const int32_t u     = limit_q31(going, params->controller.u_min, params->controller.u_max);
    const int32_t F     = force_loop_q31_exceeds(y, params->input_max) ? u : y;
    state->friction     = tribo_compensator_q31_enter(&params->compensator, &state->compensator, u, F);

    uint32_t      not_counted = 0;
    const int64_t v           = output(&from->controller, &state->controller, e);
    const int32_t term        = force_loop_q31_term(params, force_loop_q31_faded(params, state), &not_counted);
    convert(from, params, state, e, going - v - term);
}

/// To a method, from another one or from other params of the same.
static void enter_method(const tribo_force_loop_q31_params_t *from,
                         const tribo_force_loop_q31_params_t *params,
                         tribo_force_loop_q31_state_t        *state,
                         int32_t                              r,
                         int32_t                              y,
                         int32_t                              e)
{
    void *const                       memory = force_loop_q31_memory(state);
    const tribo_force_loop_q31_tick_t last   = last_of(from, state, e, y);
    const int32_t                     going  = unsaturated(from, state, r, y);
    const bool anew        = from->method == NULL || from->method->functions != params->method->functions;
    uint32_t   not_counted = 0;
    // From params of the same method: with the error of the last tick, which is close to this one's.
    convert(from, params, state, anew ? e : last.e, 0);
    if (memory != NULL)
    {
        tribo_force_loop_q31_functions_t functions;
        params->method->functions(&functions);
        const int32_t v = output(&params->controller, &state->controller, e);
        functions.enter(memory, anew ? tribo_q31_subtract(going, v, &not_counted) : last.term, anew);
    }
}

void tribo_force_loop_q31_change(const tribo_force_loop_q31_params_t *params,
                                 tribo_force_loop_q31_state_t        *state,
                                 int32_t                              r,
                                 int32_t                              y,
                                 int32_t                              e)
{
    const tribo_force_loop_q31_params_t *const from        = active(state, params);
    const tribo_friction_model_q31_t *const    model       = params->compensator.model;
    uint32_t                                   not_counted = 0;
    if (!loop_sealed(state->active, state->active_seal))
    {
        tribo_q31_count(&state->bad_inputs);
    }
    if (from == params)
    {
        if (state->active == NULL && model != NULL) // the loop's reset covers only the paper's friction
        {
            (void)model->enter(model, &params->compensator.friction, &state->compensator.friction, 0, 0);
        }
    }
    else if (params->method != NULL)
    {
        enter_method(from, params, state, r, y, e);
    }
    else if (from->method != NULL || !compensator_q31_same_model(&from->compensator, &params->compensator))
    {
        enter_compensator(from, params, state, r, y, e);
    }
    else
    {
        const int64_t was = force_loop_q31_term(from, force_loop_q31_faded(from, state), &not_counted);
        const int32_t is  = force_loop_q31_term(params, force_loop_q31_faded(params, state), &not_counted);
        convert(from, params, state, e, was - is);
        return;
    }
    force_loop_q31_activate(state, params);
}

void tribo_force_loop_q31_change_friction(const tribo_force_loop_q31_params_t *params,
                                          tribo_force_loop_q31_state_t        *state,
                                          int32_t                              e,
                                          int32_t                              u)
{
    const tribo_force_loop_q31_params_t *const from        = active(state, params);
    uint32_t                                   not_counted = 0;

    const uint32_t fade  = force_loop_q31_fade(params, state);
    const int32_t  f_was = faded_q31(tribo_compensator_q31_peek(&from->compensator, &state->compensator, u), fade);
    const int32_t  f     = faded_q31(tribo_compensator_q31_peek(&params->compensator, &state->compensator, u), fade);
    const int64_t  was   = force_loop_q31_term(params, f_was, &not_counted);
    convert(params, params, state, e, was - force_loop_q31_term(params, f, &not_counted));
    force_loop_q31_activate(state, params);
}
