// Measured friction in fixed point; observer_f32.h has the equations. Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_OBSERVER_Q31_H
#define TRIBO_FEEDFORWARD_OBSERVER_Q31_H

#include "tribo/feedforward_q31.h"
#include "tribo/q31.h"

#include "../number/first_order_q31.h"
#include "bank_q31.h"
#include "constants.h"

static inline void observer_q31_start(tribo_feedforward_observer_q31_state_t *observer, int32_t y)
{
    observer->y[0]       = y;
    observer->y[1]       = y;
    observer->noise      = 0;
    observer->actuator   = y;
    observer->sensor     = y;
    observer->force      = y;
    observer->difference = 0;
    observer->travelled  = y;
}

static inline void observer_q31_step(const tribo_feedforward_q31_params_t   *params,
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

    const int32_t  change = difference_q31(x->force, before);
    const uint32_t most   = (uint32_t)BANK_Q31_ONE;
    x->friction =
        difference_q31(x->difference, bank_q31_times(change, params->damping, 32u - params->damping_shift, most));
    // Travel of y, apart from its noise.
    const uint32_t noise = tribo_q31_high(x->noise, BANK_Q31_Q32(0.5f * FEEDFORWARD_TRAVEL_NOISE)) >> 8;
    const int32_t  half  = (int32_t)(params->travel_half + noise);
    x->travelled         = limit_q31(x->travelled, x->force - half, x->force + half);
}

#endif
