// Measured friction in fixed point; observer_f32.h has the equations. Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_OBSERVER_Q31_H
#define TRIBO_FEEDFORWARD_OBSERVER_Q31_H

#include "tribo/feedforward_q31.h"
#include "tribo/q31.h"

#include "../number/first_order_q31.h"
#include "bank_q31.h"
#include "constants.h"

/// Measurement of one tick.
typedef struct
{
    int32_t friction; ///< z
    int32_t jump;     ///< of z
    int32_t change;   ///< of yf
    int32_t travel;   ///< dm
} observer_q31_signals_t;

static inline void observer_q31_start(tribo_feedforward_observer_q31_state_t *observer, int32_t y)
{
    *observer =
        (tribo_feedforward_observer_q31_state_t){.y = {y, y}, .actuator = y, .sensor = y, .force = y, .travelled = y};
}

static inline observer_q31_signals_t observer_q31_step(const tribo_feedforward_q31_params_t   *params,
                                                       tribo_feedforward_observer_q31_state_t *x,
                                                       int32_t                                 u,
                                                       int32_t                                 y)
{
    const int32_t before = x->force;

    x->actuator   = first_order_q31_step(x->actuator, u, params->actuator_part);
    x->sensor     = first_order_q31_step(x->sensor, x->actuator, params->sensor_part);
    x->noise      = bank_q31_noise(params, x->noise, y, x->y);
    x->force      = first_order_q31_step(x->force, y, params->observer_part);
    x->difference = first_order_q31_step(x->difference, difference_q31(x->sensor, y), params->observer_part);

    const int32_t change = difference_q31(x->force, before);
    const int32_t viscous =
        bank_q31_times(change, params->damping, 32u - params->damping_shift, (uint32_t)BANK_Q31_ONE);

    const int32_t z    = difference_q31(x->difference, viscous);
    const int32_t jump = difference_q31(z, x->friction);
    x->friction        = z;

    // Travel of y, apart from its noise.
    const uint32_t noise  = tribo_q31_high(x->noise, BANK_Q31_Q32(0.5f * FEEDFORWARD_TRAVEL_NOISE)) >> 8;
    const int32_t  half   = (int32_t)(params->travel_half + noise);
    const int32_t  now    = limit_q31(x->travelled, x->force - half, x->force + half);
    const int32_t  travel = difference_q31(now, x->travelled);
    x->travelled          = now;
    x->stop[0]            = bank_q31_stop(x->stop[0], travel, params->measured_per_unit);
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        x->stop[j + 1u] = bank_q31_stop(x->stop[j + 1u], travel, params->stop_per_unit[j]);
    }
    return (observer_q31_signals_t){.friction = z, .jump = jump, .change = change, .travel = travel};
}

#endif
