/// The path from the feed-forward to the force sensor without friction, in fixed point: the twin of path_f32.h.
///
/// The path is linear, so its states are in the unit of its inputs, whatever that is. A distance beyond 32 bits saturates and is
/// counted: no force within a quarter of that can make one. Low passes stop short by less than 1/part units.
/// No loops, no divisions. Not synchronized: one state, one tick.

#ifndef TRIBO_PATH_Q31_H
#define TRIBO_PATH_Q31_H

#include "tribo/arm_q31.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// What a step reads, made by tribo_path_q31_init (quantize_feedforward_q31.h).
typedef struct
{
    uint32_t               actuator_part, sensor_part; ///< 1 - e^(-p h), Q32
    tribo_arm_q31_params_t arm;
} tribo_path_q31_params_t;

/// Distances from r.
typedef struct
{
    int32_t               actuator; ///< behind the actuator's pole
    tribo_arm_q31_state_t arm;
    int32_t               sensor;    ///< behind the sensor's pole: y expected minus r
    uint32_t              saturated; ///< since reset; stops at UINT32_MAX
} tribo_path_q31_state_t;

/// At rest at r, counters 0.
void tribo_path_q31_reset(tribo_path_q31_state_t *state);

/// r has moved by `moved`, and the input is `ahead` beyond it: advances one sample and returns y expected minus r at its end.
/// Cannot fail.
int32_t tribo_path_q31_step(const tribo_path_q31_params_t *params,
                            tribo_path_q31_state_t        *state,
                            int32_t                        moved,
                            int32_t                        ahead);

#ifdef __cplusplus
}
#endif

#endif
