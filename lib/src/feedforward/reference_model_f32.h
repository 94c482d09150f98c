// Reference model, single precision: the force sensor's reading for the feed-forward without friction.
//
//     r + ahead --> actuator, pole p_a --> arm, I F'' = K u - K F - b F' --> sensor, pole p_s --> y expected
//
// An unavoidable lag must not count as an error, so the controller gets y expected minus y.
// The gain from r to y expected is 1, so the states are distances from r, small where r is slow. This keeps the bits that a
// low pass of 0.5 N with a part of 0.05 a tick would lose (6e-7 N).
// The arm is that of arm_f32.h with the drive u - F: the feed-forward cancels friction.
// No loops, no divisions. Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_REFERENCE_MODEL_F32_H
#define TRIBO_FEEDFORWARD_REFERENCE_MODEL_F32_H

#include "tribo/feedforward_f32.h"
#include "tribo/friction_f32.h"
#include "tribo/status.h"

#include "../number/first_order_f32.h"
#include "../paper/arm_f32.h"

/// The paper's arm; poles of 200 and 55 rad/s.
tribo_reference_model_f32_config_t tribo_reference_model_f32_paper(void);

/// Checks `config` and discretises it for a sample time of 1e-6 to 0.1 s. Returns TRIBO_OK, TRIBO_ERR_NULL,
/// TRIBO_ERR_SAMPLE_TIME, TRIBO_ERR_ACTUATOR_POLE, TRIBO_ERR_SENSOR_POLE or a status of tribo_arm_f32_init. Writes nothing
/// unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_reference_model_f32_init(tribo_reference_model_f32_params_t       *params,
                                              const tribo_reference_model_f32_config_t *config,
                                              float                                     sample_time_s);

/// At rest at r, counters 0.
void tribo_reference_model_f32_reset(tribo_reference_model_f32_state_t *state);

/// One sample: r has moved by `moved`, and the input is `ahead` beyond it, both finite. Returns y expected minus r at its end.
static inline float reference_model_f32_step(const tribo_reference_model_f32_params_t *params,
                                             tribo_reference_model_f32_state_t        *state,
                                             float                                     moved,
                                             float                                     ahead)
{
    // A move of r changes all distances from it.
    const float u = first_order_f32_step(state->actuator_n - moved, ahead, params->actuator_part);
    state->arm.force_n -= moved;
    arm_f32_step(&params->arm, &state->arm, u - state->arm.force_n);
    state->actuator_n = u;
    state->sensor_n   = first_order_f32_step(state->sensor_n - moved, state->arm.force_n, params->sensor_part);
    return state->sensor_n;
}

#endif
