/// The reading that the commands of the last ticks lead to if nothing is broken and nothing rubs, whatever method made them:
///
///     u + g --> actuator's pole --> arm, Eq. (2) with f = 0 --> sensor's pole --> y expected
///
/// A healthy rig differs from it by friction, so by about L, and for a moment by what the model leaves out.

#ifndef DRIVE_EXPECTED_H
#define DRIVE_EXPECTED_H

#include "app/config.h"
#include "app/loop.h"
#include "app/scaling.h"

/// Constants of a tick.
typedef struct
{
    const TRIBO(arm, params_t) * arm; ///< of the loop's params
    loop_force_t   down;              ///< -g
    scaling_gain_t actuator, sensor;  ///< what a pole passes on in a tick, h/(1/p + h)
} expected_t;

/// Zero but for the arm at a start; expected_reset makes it so.
typedef struct
{
    loop_force_t drive, force, y; ///< behind the actuator, of the arm, behind the sensor
    TRIBO(arm, state_t) arm;
} expected_state_t;

void expected_init(expected_t *expected, const drive_config_t *config, const loop_params_t *params);
void expected_reset(expected_state_t *state);

static inline loop_force_t expected_pole(loop_force_t x, loop_force_t input, const scaling_gain_t *part)
{
    return scaling_sum(x, scaling_times(part, scaling_difference(input, x)));
}

/// A tick with `u` as applied. y of the next tick is compared with state->y.
static inline void expected_step(const expected_t *expected, expected_state_t *state, loop_force_t u)
{
    state->drive = expected_pole(state->drive, scaling_difference(u, expected->down), &expected->actuator);
    state->force = TRIBO(arm, step)(expected->arm, &state->arm, scaling_difference(state->drive, state->force));
    state->y     = expected_pole(state->y, state->force, &expected->sensor);
}

#endif
