// A change of params between two ticks. u continues from its value under the old params, even if gain, controller, friction and
// method have changed.

#include "tribo/force_loop_f32.h"

#include "../controller/anti_windup_f32.h"
#include "../friction/compensator_f32.h"
#include "../number/ieee_f32.h"
#include "loop_f32.h"

#include <stddef.h>

/// The params of the last tick; `params` after a reset or if the pointer is corrupt, which means no change.
static const tribo_force_loop_f32_params_t *active(const tribo_force_loop_f32_state_t  *state,
                                                   const tribo_force_loop_f32_params_t *params)
{
    const bool good = state->active != NULL && loop_sealed(state->active, state->active_seal);
    return good ? state->active : params;
}

/// The controller's output for `e`; no state advances.
static float output(const tribo_controller_f32_params_t *params, tribo_controller_f32_state_t *state, float e)
{
    tribo_biquad_f32_outputs_t outputs;
    return biquad_f32_output(&params->cascade, &state->cascade, e, &outputs);
}

/// The last tick under the params `from`: of the method, or of a controller alone, with the error `e` and the reading `y_n` where the
/// method had no tick.
static tribo_force_loop_f32_tick_t last_of(const tribo_force_loop_f32_params_t *from,
                                           const tribo_force_loop_f32_state_t  *state,
                                           float                                e,
                                           float                                y_n)
{
    tribo_force_loop_f32_tick_t              last = {.e_n = e, .y_n = y_n};
    const tribo_force_loop_f32_tick_t *const tick = force_loop_f32_memory(state);
    if (from->method == NULL)
    {
        last.term_n = from->gain * force_loop_f32_faded(from, state);
    }
    else if (tick != NULL)
    {
        last.e_n    = tick->has_e ? tick->e_n : e;
        last.y_n    = tick->has_e && tick->has_y ? tick->y_n : y_n;
        last.term_n = tick->term_n;
    }
    return last;
}

/// u of this tick under the params `from`, before its limit.
static float unsaturated(const tribo_force_loop_f32_params_t *from,
                         tribo_force_loop_f32_state_t        *state,
                         float                                r_n,
                         float                                y_n)
{
    const tribo_force_loop_f32_tick_t last = last_of(from, state, r_n - y_n, y_n);
    const float e = force_loop_f32_bad(from, r_n, y_n) ? 0.0f : last.e_n + (last.y_n - y_n); // with the change of y
    return output(&from->controller, &state->controller, e) + last.term_n;
}

/// From another method or friction model to the compensator: it starts at the sensor's reading, with the friction that holds the
/// arm there.
static void enter_compensator(const tribo_force_loop_f32_params_t *from,
                              const tribo_force_loop_f32_params_t *params,
                              tribo_force_loop_f32_state_t        *state,
                              float                                r_n,
                              float                                y_n,
                              float                                e)
{
    const float going = unsaturated(from, state, r_n, y_n);
    const float u     = limit_f32(going, params->controller.u_min_n, params->controller.u_max_n);
    const float F     = exceeds(y_n, params->input_max_n) ? u : y_n;
    state->friction_n = tribo_compensator_f32_enter(&params->compensator, &state->compensator, u, F);

    const float v    = output(&from->controller, &state->controller, e);
    const float term = params->gain * force_loop_f32_faded(params, state);
    tribo_controller_f32_change(&from->controller, &params->controller, &state->controller, e, going - term - v);
}

/// To a method, from another one or from other params of the same.
static void enter_method(const tribo_force_loop_f32_params_t *from,
                         const tribo_force_loop_f32_params_t *params,
                         tribo_force_loop_f32_state_t        *state,
                         float                                r_n,
                         float                                y_n,
                         float                                e)
{
    void *const                       memory = force_loop_f32_memory(state);
    const tribo_force_loop_f32_tick_t last   = last_of(from, state, e, y_n);
    const float                       going  = unsaturated(from, state, r_n, y_n);
    const bool anew = from->method == NULL || from->method->functions != params->method->functions;
    // From params of the same method: with the error of the last tick, which is close to this one's.
    tribo_controller_f32_change(&from->controller, &params->controller, &state->controller, anew ? e : last.e_n, 0.0f);
    if (memory != NULL)
    {
        tribo_force_loop_f32_functions_t functions;
        params->method->functions(&functions);
        const float v = output(&params->controller, &state->controller, e);
        functions.enter(memory, anew ? going - v : last.term_n, anew);
    }
}

void tribo_force_loop_f32_change(const tribo_force_loop_f32_params_t *params,
                                 tribo_force_loop_f32_state_t        *state,
                                 float                                r_n,
                                 float                                y_n,
                                 float                                e_n)
{
    const tribo_force_loop_f32_params_t *const from  = active(state, params);
    const tribo_friction_model_f32_t *const    model = params->compensator.model;
    if (!loop_sealed(state->active, state->active_seal))
    {
        count(&state->bad_inputs);
    }
    if (from == params)
    {
        if (state->active == NULL && model != NULL) // the loop's reset covers only the paper's friction
        {
            (void)model->enter(model, &params->compensator.friction, &state->compensator.friction, 0.0f, 0.0f);
        }
    }
    else if (params->method != NULL)
    {
        enter_method(from, params, state, r_n, y_n, e_n);
    }
    else if (from->method != NULL || !compensator_f32_same_model(&from->compensator, &params->compensator))
    {
        enter_compensator(from, params, state, r_n, y_n, e_n);
    }
    else
    {
        // Change of u by the new gain in this tick.
        const float was  = from->gain * force_loop_f32_faded(from, state);
        const float jump = params->gain * force_loop_f32_faded(params, state) - was;
        tribo_controller_f32_change(&from->controller, &params->controller, &state->controller, e_n, -jump);
        return;
    }
    force_loop_f32_activate(state, params);
}

void tribo_force_loop_f32_change_friction(const tribo_force_loop_f32_params_t *params,
                                          tribo_force_loop_f32_state_t        *state,
                                          float                                e_n,
                                          float                                u_n)
{
    const tribo_force_loop_f32_params_t *const from = active(state, params);

    const float was  = tribo_compensator_f32_peek(&from->compensator, &state->compensator, u_n);
    const float will = tribo_compensator_f32_peek(&params->compensator, &state->compensator, u_n);
    const float jump = params->gain * (will - was) * force_loop_f32_fade(params, state);
    tribo_controller_f32_change(&params->controller, &params->controller, &state->controller, e_n, -jump);
    force_loop_f32_activate(state, params);
}
