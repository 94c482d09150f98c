/// Measures hub friction from what was applied and what the sensor shows, single precision:
///
///     u --> actuator --> sensor --> u2          u as the sensor would show it if the arm had neither mass nor friction
///     z  = LP(u2 - y) - (b/K) y'                y' from LP(y)
///
/// While the arm slides steadily z = +L in a rise and -L in a fall of the force; while it sticks z is whatever the motor
/// pushes. Both are a low pass of T_y late, and both alike, so that z belongs to the force LP(y).
/// Inertia is left out: it weighs I y''/K, and nothing is learned from a force that changes fast. A constant load (gravity) is
/// measured as a difference of the two directions.
/// No loops, no divisions. Not synchronized: one state, one tick.

#ifndef TRIBO_FRICTION_METER_F32_H
#define TRIBO_FRICTION_METER_F32_H

#include "tribo/path_f32.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What a step reads, made by tribo_friction_meter_f32_init. Const from then on; may be shared.
typedef struct
{
    float actuator_part, sensor_part; ///< of path_f32.h
    float filter_part;                ///< h/(T_y + h)
    float damping;                    ///< b/(K h)
} tribo_friction_meter_f32_params_t;

/// All but y are distances from y, so that a low pass does not lose the last bits of a force that stands.
typedef struct
{
    float y_n;                  ///< the last reading
    float actuator_n, sensor_n; ///< u behind the actuator's pole, and behind the sensor's too
    float behind_n;             ///< LP(y)
    float difference_n;         ///< LP(u2 - y)
} tribo_friction_meter_f32_state_t;

/// What one step measured.
typedef struct
{
    float friction_n; ///< z
    float force_n;    ///< LP(y), to which z belongs
    float change_n;   ///< of LP(y) in this tick: y' h
} tribo_friction_meter_f32_signals_t;

/// From the same path that the model runs on, and the time constant T_y, 1e-6 to 10 s. Returns TRIBO_OK, TRIBO_ERR_NULL,
/// what tribo_path_f32_init says or TRIBO_ERR_SLIDE_FILTER. Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_friction_meter_f32_init(tribo_friction_meter_f32_params_t *params,
                                             const tribo_path_f32_config_t     *path,
                                             float                              filter_time_s,
                                             float                              sample_time_s);

/// As if u and y had stood at `force_n` for ever. A bad force counts as 0.
void tribo_friction_meter_f32_reset(tribo_friction_meter_f32_state_t *state, float force_n);

/// Takes `u_n` as applied and the reading `y_n`, both in N. Cannot fail: with a bad one (NaN, or beyond
/// TRIBO_F32_FORCE_MAX_N) the filters stand still. `signals` is written whole and must not be null.
void tribo_friction_meter_f32_step(const tribo_friction_meter_f32_params_t *params,
                                   tribo_friction_meter_f32_state_t        *state,
                                   float                                    u_n,
                                   float                                    y_n,
                                   tribo_friction_meter_f32_signals_t      *signals);

#ifdef __cplusplus
}
#endif

#endif
