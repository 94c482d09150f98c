// Friction observer in fixed point; friction_observer_f32.h has the equations.
//
// Forces are within +-2^29, a quarter of 32 bits, so that their differences fit. A change of LP(y) counts up to 2^30 K h/b.
// Low passes stop short by less than 1/part units (21 units for the paper's T_y, 8e-8 N at a full scale of 2 N).
// No loops, no divisions. Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_FRICTION_OBSERVER_Q31_H
#define TRIBO_FEEDFORWARD_FRICTION_OBSERVER_Q31_H

#include "tribo/feedforward_q31.h"
#include "tribo/q31.h"

#include "../number/first_order_q31.h"

/// Returns TRIBO_OK or a status of tribo_friction_observer_f32_init. Writes nothing unless TRIBO_OK.
tribo_status_t tribo_friction_observer_q31_init(tribo_friction_observer_q31_params_t     *params,
                                                const tribo_reference_model_f32_config_t *reference_model,
                                                float                                     filter_time_s,
                                                float                                     sample_time_s);

/// As if u and y had always been `force`.
void tribo_friction_observer_q31_reset(tribo_friction_observer_q31_state_t *state, int32_t force);

/// One sample of `u` as applied and the reading `y`, both within +-2^29. Writes all of `signals`.
static inline void friction_observer_q31_step(const tribo_friction_observer_q31_params_t *params,
                                              tribo_friction_observer_q31_state_t        *state,
                                              int32_t                                     u,
                                              int32_t                                     y,
                                              tribo_friction_observer_q31_signals_t      *signals)
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
