// One sample of the path.

#ifndef TRIBO_PATH_Q31_STEP_H
#define TRIBO_PATH_Q31_STEP_H

#include "tribo/path_q31.h"

#include "arm_q31_step.h"
#include "first_order_q31.h"

/// A low pass whose distances may not fit.
static inline int32_t path_q31_pass(int32_t x, int32_t input, uint32_t part, uint32_t *saturated)
{
    return x + part_of_q31(tribo_q31_subtract(input, x, saturated), part);
}

static inline int32_t path_q31_step(const tribo_path_q31_params_t *params,
                                    tribo_path_q31_state_t        *state,
                                    int32_t                        moved,
                                    int32_t                        ahead)
{
    uint32_t *const saturated = &state->saturated;

    // Where r moves, all distances from it do.
    const int32_t actuator = tribo_q31_subtract(state->actuator, moved, saturated);
    const int32_t u        = path_q31_pass(actuator, ahead, params->actuator_part, saturated);

    const int32_t before = tribo_q31_subtract(tribo_arm_q31_force(&state->arm), moved, saturated);
    state->arm.force     = (int64_t)((uint64_t)state->arm.force - ((uint64_t)(int64_t)moved << 28)); // wraps if corrupt
    arm_q31_step(&params->arm, &state->arm, tribo_q31_subtract(u, before, saturated));

    const int32_t sensor = tribo_q31_subtract(state->sensor, moved, saturated);
    state->actuator      = u;
    state->sensor        = path_q31_pass(sensor, tribo_arm_q31_force(&state->arm), params->sensor_part, saturated);
    return state->sensor;
}

#endif
