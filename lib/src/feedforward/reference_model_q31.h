// Reference model in fixed point; reference_model_f32.h has the equation.
//
// The model is linear, so its states have the unit of its inputs. A distance beyond 32 bits saturates and is counted; forces
// below a quarter of that range do not reach it. A low pass stops short of its input by less than 1/part units.
// No loops, no divisions. Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_REFERENCE_MODEL_Q31_H
#define TRIBO_FEEDFORWARD_REFERENCE_MODEL_Q31_H

#include "tribo/feedforward_q31.h"
#include "tribo/friction_q31.h"

#include "../number/first_order_q31.h"
#include "../paper/arm_q31.h"

/// Returns TRIBO_OK or a status of tribo_reference_model_f32_init or tribo_arm_q31_init. Writes nothing unless TRIBO_OK.
tribo_status_t tribo_reference_model_q31_init(tribo_reference_model_q31_params_t       *params,
                                              const tribo_reference_model_f32_config_t *config,
                                              float                                     sample_time_s);

/// At rest at r, counters 0.
void tribo_reference_model_q31_reset(tribo_reference_model_q31_state_t *state);

/// A low pass whose distances may not fit.
static inline int32_t reference_model_q31_pass(int32_t x, int32_t input, uint32_t part, uint32_t *saturated)
{
    return x + part_of_q31(tribo_q31_subtract(input, x, saturated), part);
}

/// One sample: r has moved by `moved`, and the input is `ahead` beyond it. Returns y expected minus r at its end.
static inline int32_t reference_model_q31_step(const tribo_reference_model_q31_params_t *params,
                                               tribo_reference_model_q31_state_t        *state,
                                               int32_t                                   moved,
                                               int32_t                                   ahead)
{
    uint32_t *const saturated = &state->saturated;

    // A move of r changes all distances from it.
    const int32_t actuator = tribo_q31_subtract(state->actuator, moved, saturated);
    const int32_t u        = reference_model_q31_pass(actuator, ahead, params->actuator_part, saturated);

    const int32_t before = tribo_q31_subtract(tribo_arm_q31_force(&state->arm), moved, saturated);
    state->arm.force     = (int64_t)((uint64_t)state->arm.force - ((uint64_t)(int64_t)moved << 28)); // wraps if corrupt
    arm_q31_step(&params->arm, &state->arm, tribo_q31_subtract(u, before, saturated));

    const int32_t sensor = tribo_q31_subtract(state->sensor, moved, saturated);
    state->actuator      = u;
    state->sensor = reference_model_q31_pass(sensor, tribo_arm_q31_force(&state->arm), params->sensor_part, saturated);
    return state->sensor;
}

#endif
