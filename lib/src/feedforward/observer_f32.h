// Measured friction, single precision: step 10 of docs/feedforward.md. No loops, no divisions.
// Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_OBSERVER_F32_H
#define TRIBO_FEEDFORWARD_OBSERVER_F32_H

#include "tribo/feedforward_f32.h"

#include "../number/first_order_f32.h"
#include "bank_f32.h"
#include "constants.h"

/// As if u and y had always been `y`, with no friction.
static inline void observer_f32_start(tribo_feedforward_observer_f32_state_t *observer, float y)
{
    observer->y_n[0]       = y;
    observer->y_n[1]       = y;
    observer->noise_n      = 0.0f;
    observer->actuator_n   = y;
    observer->sensor_n     = y;
    observer->force_n      = y;
    observer->difference_n = 0.0f;
    observer->friction_n   = 0.0f;
    observer->travelled_n  = y;
}

/// One tick with `u` as applied and the reading `y`.
static inline void observer_f32_step(const tribo_feedforward_f32_params_t   *params,
                                     tribo_feedforward_observer_f32_state_t *x,
                                     float                                   u,
                                     float                                   y)
{
    const float before = x->force_n;

    x->actuator_n   = first_order_f32_step(x->actuator_n, u, params->actuator_part);
    x->sensor_n     = first_order_f32_step(x->sensor_n, x->actuator_n, params->sensor_part);
    x->noise_n      = bank_f32_noise(params, x->noise_n, y, x->y_n);
    x->force_n      = first_order_f32_step(x->force_n, y, params->observer_part);
    x->difference_n = first_order_f32_step(x->difference_n, x->sensor_n - y, params->observer_part);
    x->friction_n   = x->difference_n - params->damping * (x->force_n - before);
    // Travel of y, apart from its noise.
    const float half = params->travel_half_n + 0.5f * FEEDFORWARD_TRAVEL_NOISE * x->noise_n;
    x->travelled_n   = limit_f32(x->travelled_n, x->force_n - half, x->force_n + half);
}

#endif
