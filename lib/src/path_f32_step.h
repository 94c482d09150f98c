// One sample of the path, for an input that is known to be good.

#ifndef TRIBO_PATH_F32_STEP_H
#define TRIBO_PATH_F32_STEP_H

#include "tribo/path_f32.h"

#include "arm_f32_step.h"
#include "first_order_f32.h"

static inline float path_f32_step(const tribo_path_f32_params_t *params,
                                  tribo_path_f32_state_t        *state,
                                  float                          moved,
                                  float                          ahead)
{
    // Where r moves, all distances from it do.
    const float u = first_order_f32_step(state->actuator_n - moved, ahead, params->actuator_part);
    state->arm.force_n -= moved;
    arm_f32_step(&params->arm, &state->arm, u - state->arm.force_n);
    state->actuator_n = u;
    state->sensor_n   = first_order_f32_step(state->sensor_n - moved, state->arm.force_n, params->sensor_part);
    return state->sensor_n;
}

#endif
