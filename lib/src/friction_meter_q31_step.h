// One sample of the friction meter, for forces within +-2^29.

#ifndef TRIBO_FRICTION_METER_Q31_STEP_H
#define TRIBO_FRICTION_METER_Q31_STEP_H

#include "tribo/friction_meter_q31.h"

#include "first_order_q31.h"
#include "limit_q31.h"

static inline void friction_meter_q31_step(const tribo_friction_meter_q31_params_t *params,
                                           tribo_friction_meter_q31_state_t        *state,
                                           int32_t                                  u,
                                           int32_t                                  y,
                                           tribo_friction_meter_q31_signals_t      *signals)
{
    const int32_t u1     = first_order_q31_step(state->actuator, u, params->actuator_part);
    const int32_t u2     = first_order_q31_step(state->sensor, u1, params->sensor_part);
    const int32_t yf     = first_order_q31_step(state->force, y, params->filter_part);
    const int32_t df     = first_order_q31_step(state->difference, u2 - y, params->filter_part);
    const int32_t change = yf - state->force;

    state->actuator   = u1;
    state->sensor     = u2;
    state->force      = yf;
    state->difference = df;

    // Where F changes so fast that its product would not fit, z is of no use.
    const int32_t fits = limit_q31(change, -params->change_max, params->change_max);
    signals->friction  = df - part_of_q31(fits * (int32_t)(UINT32_C(1) << params->damping_shift), params->damping);
    signals->force     = yf;
    signals->change    = change;
}

#endif
