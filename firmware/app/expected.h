/// Predicts the reading that the past commands lead to on an intact rig without friction, for commands of any method:
///
///     u + g --> actuator's pole --> arm, Eq. (2) with f = 0 --> sensor's pole --> y expected
///
/// A healthy rig differs from the prediction by its friction, about L, and briefly by the dynamics that the model leaves out.

#ifndef DRIVE_EXPECTED_H
#define DRIVE_EXPECTED_H

#include "app/config.h"
#include "app/loop.h"
#include "app/scaling.h"

/// Constants of the model.
typedef struct
{
    const TRIBO(arm, params_t) * arm; ///< of the loop's params
    loop_force_t   down;              ///< -g
    scaling_gain_t actuator, sensor;  ///< part of its input step that a pole p passes in a tick, h/(1/p + h)
} expected_t;

/// The state of the model. expected_reset makes it the state at rest: all zero except for the arm.
typedef struct
{
    loop_force_t drive, force, y; ///< outputs of the actuator, the arm and the sensor
    TRIBO(arm, state_t) arm;
} expected_state_t;

void expected_init(expected_t *expected, const drive_config_t *config, const loop_params_t *params);
void expected_reset(expected_state_t *state);

static inline loop_force_t expected_pole(loop_force_t x, loop_force_t input, const scaling_gain_t *part)
{
    return scaling_sum(x, scaling_times(part, scaling_difference(input, x)));
}

/// Advances the model by one tick in which `u` is applied. Compare y of the next tick with state->y.
static inline void expected_step(const expected_t *expected, expected_state_t *state, loop_force_t u)
{
    state->drive = expected_pole(state->drive, scaling_difference(u, expected->down), &expected->actuator);
    state->force = TRIBO(arm, step)(expected->arm, &state->arm, scaling_difference(state->drive, state->force));
    state->y     = expected_pole(state->y, state->force, &expected->sensor);
}

#endif
