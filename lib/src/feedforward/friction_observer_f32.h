// Friction observer, single precision: hub friction from the applied u and the reading y.
//
//     u --> actuator --> sensor --> u2          the reading if the arm had neither mass nor friction
//     z  = LP(u2 - y) - (b/K) y'                y' from LP(y)
//
// While the arm slides steadily z = +L in a rise of the force and -L in a fall; while it sticks z is the net motor force.
// z and LP(y) have the same lag T_y, so z belongs to the force LP(y).
// Inertia, I y''/K, is neglected: there is no learning from a force that changes fast. A constant load (gravity) shows as a
// difference of the two directions.
// No loops, no divisions. Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_FRICTION_OBSERVER_F32_H
#define TRIBO_FEEDFORWARD_FRICTION_OBSERVER_F32_H

#include "tribo/feedforward_f32.h"

#include "../number/first_order_f32.h"
#include "reference_model_f32.h"

/// From the reference model's config and the time constant T_y, 1e-6 to 10 s. Returns TRIBO_OK, TRIBO_ERR_NULL, a status of
/// tribo_reference_model_f32_init or TRIBO_ERR_SLIDE_FILTER. Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_friction_observer_f32_init(tribo_friction_observer_f32_params_t     *params,
                                                const tribo_reference_model_f32_config_t *reference_model,
                                                float                                     filter_time_s,
                                                float                                     sample_time_s);

/// As if u and y had always been `force_n`. A bad force counts as 0.
void tribo_friction_observer_f32_reset(tribo_friction_observer_f32_state_t *state, float force_n);

/// One sample of the applied `u` and the reading `y`, both finite. Writes all of `signals`.
static inline void friction_observer_f32_step(const tribo_friction_observer_f32_params_t *params,
                                              tribo_friction_observer_f32_state_t        *state,
                                              float                                       u,
                                              float                                       y,
                                              tribo_friction_observer_f32_signals_t      *signals)
{
    // A move of y changes all distances from it.
    const float moved  = y - state->y_n;
    const float u1     = first_order_f32_step(state->actuator_n - moved, u - y, params->actuator_part);
    const float u2     = first_order_f32_step(state->sensor_n - moved, u1, params->sensor_part);
    const float behind = first_order_f32_step(state->behind_n - moved, 0.0f, params->filter_part);
    const float change = moved + (behind - state->behind_n);

    state->y_n        = y;
    state->actuator_n = u1;
    state->sensor_n   = u2;
    state->behind_n   = behind;
    state->difference_n += params->filter_part * (u2 - state->difference_n);

    signals->friction_n = state->difference_n - params->damping * change;
    signals->force_n    = y + behind;
    signals->change_n   = change;
}

#endif
