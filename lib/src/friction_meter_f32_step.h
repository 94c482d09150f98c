// One sample of the friction meter, for inputs that are known to be good.

#ifndef TRIBO_FRICTION_METER_F32_STEP_H
#define TRIBO_FRICTION_METER_F32_STEP_H

#include "tribo/friction_meter_f32.h"

#include "first_order_f32.h"

static inline void friction_meter_f32_step(const tribo_friction_meter_f32_params_t *params,
                                           tribo_friction_meter_f32_state_t        *state,
                                           float                                    u,
                                           float                                    y,
                                           tribo_friction_meter_f32_signals_t      *signals)
{
    // Where y moves, all distances from it do.
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
