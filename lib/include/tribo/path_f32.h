/// The path from the feed-forward to the force sensor as it would be without friction, single precision:
///
///     r + ahead --> actuator, pole p_a --> arm, I F'' = K u - K F - b F' --> sensor, pole p_s --> y expected
///
/// What a good feed-forward makes of the reference r must not count as an error: the controller gets y expected minus y.
/// The gain from r to y expected is 1, so the states are kept as distances from r, which are small where r is slow: y expected
/// is r plus the last one. That keeps the bits that a low pass of 0.5 N with a part of 0.05 a tick would lose (6e-7 N).
/// The arm is arm_f32.h with its drive u - F, friction being what the feed-forward takes care of.
/// No loops, no divisions. Not synchronized: one state, one tick.

#ifndef TRIBO_PATH_F32_H
#define TRIBO_PATH_F32_H

#include "tribo/arm_f32.h"
#include "tribo/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct
{
    float                  actuator_pole_rad_per_s; ///< over 0; pole times sample time at most 50
    float                  sensor_pole_rad_per_s;   ///< likewise
    tribo_arm_f32_config_t arm;
} tribo_path_f32_config_t;

/// What a step reads, made by tribo_path_f32_init. Const from then on; may be shared.
typedef struct
{
    float                  actuator_part, sensor_part; ///< of the way to a held input in a tick, 1 - e^(-p h)
    tribo_arm_f32_params_t arm;
} tribo_path_f32_params_t;

/// Distances from r.
typedef struct
{
    float                 actuator_n; ///< behind the actuator's pole
    tribo_arm_f32_state_t arm;
    float                 sensor_n; ///< behind the sensor's pole: y expected minus r
} tribo_path_f32_state_t;

/// The paper's arm; poles of 200 and 55 rad/s.
tribo_path_f32_config_t tribo_path_f32_paper(void);

/// Checks `config` and discretises it for a sample time of 1e-6 to 0.1 s. Returns TRIBO_OK, TRIBO_ERR_NULL,
/// TRIBO_ERR_SAMPLE_TIME, TRIBO_ERR_ACTUATOR_POLE, TRIBO_ERR_SENSOR_POLE or what tribo_arm_f32_init says. Writes nothing
/// unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_path_f32_init(tribo_path_f32_params_t       *params,
                                   const tribo_path_f32_config_t *config,
                                   float                          sample_time_s);

/// At rest at r, counters 0.
void tribo_path_f32_reset(tribo_path_f32_state_t *state);

/// r has moved by `moved_n`, and the input is `ahead_n` beyond it, in N: advances one sample and returns y expected minus r at
/// its end. Cannot fail: a bad input (NaN, or beyond 2 TRIBO_F32_FORCE_MAX_N) counts as 0.
float tribo_path_f32_step(const tribo_path_f32_params_t *params,
                          tribo_path_f32_state_t        *state,
                          float                          moved_n,
                          float                          ahead_n);

#ifdef __cplusplus
}
#endif

#endif
