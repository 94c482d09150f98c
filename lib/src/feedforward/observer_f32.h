// Measured friction, and the stops on the measured force, single precision: steps 10 and 11 of docs/feedforward.md.
// No loops but the stops', no divisions. Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_OBSERVER_F32_H
#define TRIBO_FEEDFORWARD_OBSERVER_F32_H

#include "tribo/feedforward_f32.h"

#include "../number/first_order_f32.h"
#include "bank_f32.h"
#include "constants.h"

/// Measurement of one tick.
typedef struct
{
    float friction_n; ///< z, which belongs to yf
    float jump_n;     ///< of z in this tick
    float change_n;   ///< of yf in this tick
    float travel_n;   ///< dm
} observer_f32_signals_t;

/// As if u and y had always been `y`, with no friction.
static inline void observer_f32_start(tribo_feedforward_observer_f32_state_t *observer, float y)
{
    *observer = (tribo_feedforward_observer_f32_state_t){.y_n         = {y, y},
                                                         .actuator_n  = y,
                                                         .sensor_n    = y,
                                                         .force_n     = y,
                                                         .travelled_n = y};
}

/// One tick with `u` as applied and the reading `y`. A state that is no longer finite starts again.
static inline observer_f32_signals_t observer_f32_step(const tribo_feedforward_f32_params_t   *params,
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

    const float change = x->force_n - before;
    const float z      = x->difference_n - params->damping * change;
    if (exceeds(z, FEEDFORWARD_FORCE_MAX_N))
    {
        observer_f32_start(x, y);
        return (observer_f32_signals_t){.friction_n = 0.0f};
    }
    const float jump = z - x->friction_n;
    x->friction_n    = z;
    // Travel of y, apart from its noise.
    const float half   = params->travel_half_n + 0.5f * FEEDFORWARD_TRAVEL_NOISE * x->noise_n;
    const float now    = limit_f32(x->travelled_n, x->force_n - half, x->force_n + half);
    const float travel = now - x->travelled_n;
    x->travelled_n     = now;
    x->stop[0]         = bound_f32(x->stop[0] + travel * params->measured_per_n, 1.0f);
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        x->stop[j + 1u] = bound_f32(x->stop[j + 1u] + travel * params->stop_per_n[j], 1.0f);
    }
    return (observer_f32_signals_t){.friction_n = z, .jump_n = jump, .change_n = change, .travel_n = travel};
}

#endif
