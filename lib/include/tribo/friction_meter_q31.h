/// Measures hub friction in fixed point: the twin of friction_meter_f32.h.
///
/// Forces are within +-2^29, a quarter of 32 bits, so that their differences fit. A change of LP(y) counts up to 2^30 K h/b.
/// Low passes stop short by less than 1/part units (21 units for the paper's T_y, 8e-8 N at a full scale of 2 N).
/// No loops, no divisions. Not synchronized: one state, one tick.

#ifndef TRIBO_FRICTION_METER_Q31_H
#define TRIBO_FRICTION_METER_Q31_H

#include "tribo/q31.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// What a step reads, made by tribo_friction_meter_q31_init (quantize_feedforward_q31.h).
typedef struct
{
    uint32_t actuator_part, sensor_part; ///< of path_q31.h
    uint32_t filter_part;                ///< h/(T_y + h), Q32
    uint32_t damping;                    ///< b/(K h) 2^-damping_shift, Q32
    int32_t  change_max;                 ///< 2^(30 - damping_shift)
    uint8_t  damping_shift;              ///< 0 to 15
} tribo_friction_meter_q31_params_t;

typedef struct
{
    int32_t actuator, sensor; ///< u behind the actuator's pole, and behind the sensor's too
    int32_t force;            ///< LP(y)
    int32_t difference;       ///< LP(u2 - y)
} tribo_friction_meter_q31_state_t;

/// What one step measured.
typedef struct
{
    int32_t friction; ///< z
    int32_t force;    ///< LP(y), to which z belongs
    int32_t change;   ///< of LP(y) in this tick: y' h
} tribo_friction_meter_q31_signals_t;

/// As if u and y had stood at `force` for ever.
void tribo_friction_meter_q31_reset(tribo_friction_meter_q31_state_t *state, int32_t force);

/// Takes `u` as applied and the reading `y`. Cannot fail: what is beyond +-2^29 counts as the nearest that is not. `signals` is
/// written whole and must not be null.
void tribo_friction_meter_q31_step(const tribo_friction_meter_q31_params_t *params,
                                   tribo_friction_meter_q31_state_t        *state,
                                   int32_t                                  u,
                                   int32_t                                  y,
                                   tribo_friction_meter_q31_signals_t      *signals);

#ifdef __cplusplus
}
#endif

#endif
