/// The feed-forward in fixed point: the twin of feedforward_f32.h, with the same steps.
///
/// Arguments and results are Q31 of one full scale FS, as in the rest of the library. Inside, forces are Q29 of FS, a quarter of
/// 32 bits, so that lin (within 2 FS), f and b (each within FS), and the difference of any two forces fit. A unit is 2^-29 FS,
/// 4e-9 N at 2 N.
///
///     forces, travel                      Q29, rounded towards zero
///     noise of r and y                    Q37, up to FS/64
///     rate of r, a tick                   Q37, up to FS/128
///     V, W, sigma, stops, regressors      Q29, within +-4
///     M and P, in units of their prior    Q30
///     doubt, fractions                    Q32
///
/// Mirrored inputs, without gravity, give mirrored bits; all forces and FS times 2 give the same bits. e and the sum
/// lin + f + lead - b are limited to FS.
/// A tick has at most seven divisions of 32 bits, one or two more with a table; learning is spread over ten ticks.
/// Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_Q31_H
#define TRIBO_FEEDFORWARD_Q31_H

#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_q31.h"
#include "tribo/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Constants of a tick, made by tribo_feedforward_q31_init; see the twin.
typedef struct
{
    tribo_force_loop_q31_method_t method;                                 ///< for a loop with the feed-forward
    uint32_t                      input_max;                              ///< Q31
    int32_t                       offset_max;                             ///< up to FS, Q29
    uint32_t                      reversal;                               ///< w, Q29
    uint32_t                      stop_per_unit[TRIBO_FEEDFORWARD_STOPS]; ///< FS/d_j, Q10
    int32_t                       jump;                                   ///< Q29
    uint32_t                      lead;                                   ///< Q16
    uint32_t                      distrust;                               ///< Q32
    uint32_t                      lag;                                    ///< tau/(256 h) 2^-lag_shift, Q32
    uint8_t                       lag_shift;                              ///< 0 to 8
    uint8_t                       damping_shift;                          ///< 0 to 15
    uint32_t                      noise_part;                             ///< Q32, as all parts
    uint32_t                      noise_floor;                            ///< Q37
    uint32_t                      rate_part;
    int32_t                       step; ///< Q29
    uint32_t                      lag_part, actuator_part, sensor_part, observer_part;
    uint32_t                      damping;                         ///< b/(K h) 2^-damping_shift, Q32
    uint32_t                      jump_lag;                        ///< T_z over the time of a sample, Q16
    uint32_t                      measured_per_unit;               ///< FS/d_0, Q10
    uint32_t                      travel_half;                     ///< Q29
    uint32_t                      slip;                            ///< travel of a sample that is one, Q29
    uint32_t                      travel_max;                      ///< Q29
    uint32_t                      weighing;                        ///< Q29
    uint32_t                      doubt_per_unit, margin_per_unit; ///< of a unit of travel, Q40
    uint32_t                      forgetting_per_unit;             ///< likewise, Q56
    uint32_t                      constant_sd;                     ///< Q29
    int32_t                       constant_max;                    ///< Q29
    uint32_t                      still_ticks, quick_ticks;
    uint32_t                      deadband_part;
    uint32_t                      effort_part, effort_half; ///< mu B/2, Q29
} tribo_feedforward_q31_params_t;

typedef struct
{
    int32_t  anchor;       ///< a
    uint32_t extra_margin; ///< lambda, Q32
    int32_t  error;        ///< filtered error, in a hold a step of r
    uint32_t noise;        ///< mean second difference of y over ticks in which y changed, Q37
    uint32_t changed;      ///< fraction of ticks in which y changed, Q32
    uint32_t still, since;
    int8_t   side;
    uint8_t  quick;
    uint8_t  rests; ///< the error is within the noise, and u stays
} tribo_feedforward_hold_q31_state_t;

typedef struct
{
    int32_t  y[2];
    uint32_t noise; ///< Q37
    int32_t  actuator, sensor, force, difference, friction, travelled;
} tribo_feedforward_observer_q31_state_t;

typedef struct
{
    int32_t  weight[1u + TRIBO_FEEDFORWARD_STOPS]; ///< V_j, Q29
    int32_t  constant;                             ///< c_0, Q29 of FS
    int32_t  slope, scale;                         ///< c_1, c_2, Q29
    int32_t  covariance[10];                       ///< Q30
    int32_t  variance[TRIBO_FEEDFORWARD_STOPS];    ///< Q30
    uint32_t doubt;                                ///< Q32
    uint64_t travel;                               ///< learned from, Q29
    int32_t  use[1u + TRIBO_FEEDFORWARD_STOPS];    ///< W_j, Q29
    uint32_t seal;                                 ///< of these numbers: one that does not fit is corrupt
} tribo_feedforward_weights_q31_t;

typedef struct
{
    uint8_t  stage;
    int8_t   side;
    uint8_t  hunts;
    uint32_t since;
    int32_t  stop[1u + TRIBO_FEEDFORWARD_STOPS]; ///< Q29
    int32_t  travelled, force, friction, jump;
    uint32_t sample;
    int32_t  regressor[4 + TRIBO_FEEDFORWARD_STOPS]; ///< Q29
    int32_t  error, load;                            ///< Q26
    uint32_t weighing;
    uint32_t gain;                                ///< Q31
    uint32_t presliding;                          ///< Q32
    int32_t  gained[4 + TRIBO_FEEDFORWARD_STOPS]; ///< Q27
    uint32_t seal;
} tribo_feedforward_learning_q31_state_t;

typedef struct
{
    int32_t                      v, played;
    uint32_t                     travel;
    int32_t                      need;
    uint32_t                     ratio; ///< xi, Q29
    uint8_t                      begun;
    tribo_feedforward_feedback_t feedback;
} tribo_feedforward_monitor_q31_state_t;

/// See the twin. Forces are Q29.
typedef struct
{
    tribo_force_loop_q31_tick_t            tick; ///< what the loop reads, Q31
    uint8_t                                mode, offset_rule, at_bound;
    int8_t                                 sign, limited;
    int32_t                                r[2];
    uint32_t                               noise;                         ///< Q37
    int32_t                                reached;                       ///< rs
    int32_t                                rate;                          ///< filtered change of rs in a tick, Q37
    int32_t                                settled, turned;               ///< rn, rp
    int32_t                                stop[TRIBO_FEEDFORWARD_STOPS]; ///< phi_j, Q29
    int32_t                                sigma;                         ///< Q29
    int32_t                                behind[2];                     ///< m_1 and m_2 less rs
    int32_t                                offset, f, u;
    uint32_t                               offset_seal; ///< of b from a tick to the next
    int32_t                                v;           ///< low pass of v
    uint32_t                               forgotten;   ///< stops at UINT32_MAX
    tribo_feedforward_hold_q31_state_t     hold;
    tribo_feedforward_observer_q31_state_t observer;
    tribo_feedforward_weights_q31_t        learned;
    tribo_feedforward_learning_q31_state_t learning;
    tribo_feedforward_monitor_q31_state_t  monitor;
} tribo_feedforward_q31_state_t;

/// Signals of one tick, for logging and between its three parts. Q29 unless stated otherwise.
typedef struct
{
    int32_t  e;        ///< in Q29, before its limit
    int32_t  y;        ///< y, or the last good one
    int32_t  reached;  ///< rs
    int32_t  load;     ///< of lin, what does not reverse
    int32_t  lin;      ///< force without friction for the reference
    uint32_t level;    ///< G without doubt
    int64_t  partial;  ///< W1 phi1 + ... + W4 phi4, Q58
    int32_t  f;        ///< friction fed forward, or back in a hold
    int32_t  lead;     ///< of a jump
    int32_t  b;        ///< offset
    int32_t  term;     ///< lin + f + lead - b, added to v, Q31
    int32_t  friction; ///< z, measured
    uint32_t travel;   ///< learned from, of the sample of this tick
    int32_t  need;     ///< f - b of the last tick
    bool     y_good;   ///< learning is allowed
    bool     flips;    ///< r reverses
} tribo_feedforward_q31_signals_t;

/// Learned breakaway in one direction; see the twin.
typedef struct
{
    uint32_t L;                 ///< at some force, Q29
    uint32_t relative_variance; ///< Q31
    uint64_t travel;            ///< Q29
    bool     at_bound, stays_at_bound, harms;
    uint32_t forgotten;
} tribo_feedforward_q31_learned_t;

/// See the twin. Motion is Q28 of a width.
typedef struct
{
    int32_t  moved;  ///< Q28
    int32_t  effort; ///< Q29 of FS
    int32_t  slack;  ///< Q28
    int8_t   side;
    uint32_t ticks;
    int64_t  travel;                ///< Q28
    int64_t  work, prior;           ///< Q29 of FS
    int32_t  last_travel;           ///< Q8
    int32_t  last_work, last_prior; ///< Q27 of FS
} tribo_feedforward_q31_effort_t;

/// Of a loop without a sensor.
typedef struct
{
    int32_t                        slack[2]; ///< Q29
    int8_t                         sign;
    uint8_t                        is_known, was_known;
    int32_t                        measured; ///< Q29
    tribo_feedforward_q31_effort_t effort;
} tribo_feedforward_q31_motion_t;

/// Memory of a feed-forward, attached to a loop.
typedef struct
{
    tribo_feedforward_q31_state_t   state;
    tribo_feedforward_q31_signals_t signals; ///< of the last tick, for logging
    tribo_feedforward_q31_motion_t  motion;
} tribo_feedforward_q31_memory_t;

/// Returns TRIBO_OK, TRIBO_ERR_FULL_SCALE, a status of tribo_feedforward_f32_init, or that of a parameter that full_scale_n does
/// not suit. Writes nothing unless TRIBO_OK. It leaves params.method empty, as tribo_feedforward_f32_init.
tribo_status_t tribo_feedforward_q31_init(tribo_feedforward_q31_params_t       *params,
                                          const tribo_feedforward_f32_config_t *config,
                                          const tribo_arm_f32_config_t         *arm,
                                          const tribo_friction_f32_params_t    *friction,
                                          float                                 input_max_n,
                                          float                                 usual_force_n,
                                          float                                 sample_time_s,
                                          float                                 full_scale_n);

/// Nothing learned; the next good tick is the first.
void tribo_feedforward_q31_reset(tribo_feedforward_q31_state_t *state);

/// Learned breakaway in `direction` at the end-point force `force`, Q31. Not for every tick.
tribo_feedforward_q31_learned_t tribo_feedforward_q31_learned(const tribo_friction_q31_params_t   *friction,
                                                              const tribo_feedforward_q31_state_t *state,
                                                              uint32_t                             direction,
                                                              int32_t                              force);

/// Unlatches stays_at_bound and harms, and feeds friction forward; learned values stay.
void tribo_feedforward_q31_restore(tribo_feedforward_q31_state_t *state);

/// Writes the functions of the feed-forward as a method of the force loop, for the first member of its params.
void tribo_feedforward_q31_method(tribo_force_loop_q31_functions_t *functions);

/// The feed-forward's params of a loop; null for another method.
static inline const tribo_feedforward_q31_params_t *tribo_feedforward_q31_of(
    const tribo_force_loop_q31_params_t *params)
{
    const bool is_one = params->method != NULL && params->method->functions == tribo_feedforward_q31_method;
    return is_one ? (const tribo_feedforward_q31_params_t *)params->method : NULL; // its first member
}

/// Call after a reset of `state`: `memory` restarts with it, but keeps learned values. Reset `memory` once before; it must
/// outlive `state`. Null: none.
void tribo_force_loop_feedforward_q31_attach(tribo_force_loop_q31_state_t   *state,
                                             tribo_feedforward_q31_memory_t *memory);

/// A loop with the feed-forward, as tribo_force_loop_feedforward_f32_init: `params` will point to `feedforward`. `table` and
/// `headroom` as for tribo_force_loop_q31_init. Returns TRIBO_OK or a status of that function, then of
/// tribo_feedforward_q31_init. Writes `table` if the former succeeds.
tribo_status_t tribo_force_loop_feedforward_q31_init(tribo_force_loop_q31_params_t        *params,
                                                     tribo_breakaway_point_q31_t          *table,
                                                     tribo_feedforward_q31_params_t       *feedforward,
                                                     const tribo_force_loop_f32_config_t  *config,
                                                     const tribo_feedforward_f32_config_t *feedforward_config,
                                                     float                                 full_scale_n,
                                                     tribo_headroom_q31_t                 *headroom);

// --- without a force sensor; see the twin -----------------------------------------------------------------------------
//
// What u goes on from after a change of params is within full scale of the controller's output.

/// See the twin.
tribo_status_t tribo_force_loop_sensorless_q31_init(tribo_force_loop_q31_params_t        *params,
                                                    tribo_breakaway_point_q31_t          *table,
                                                    tribo_feedforward_q31_params_t       *feedforward,
                                                    const tribo_force_loop_f32_config_t  *config,
                                                    const tribo_feedforward_f32_config_t *feedforward_config,
                                                    const tribo_sensorless_f32_config_t  *sensorless_config,
                                                    float                                 full_scale_n,
                                                    tribo_headroom_q31_t                 *headroom);

/// See the twin; widths in Q29. A tick of more than 3.9 widths is taken for none.
void tribo_sensorless_q31_motion(tribo_feedforward_q31_memory_t *memory, int32_t intended, int32_t measured);

/// Of F, from u alone; Q29.
typedef struct
{
    uint32_t runs;
    int32_t  lagged, force, low, high;
} tribo_force_estimate_q31_t;

/// See the twin; `tolerance` in Q32.
void tribo_force_estimate_q31_step(const tribo_force_loop_q31_params_t  *params,
                                   const tribo_feedforward_q31_params_t *feedforward,
                                   tribo_force_estimate_q31_t           *estimate,
                                   uint32_t                              tolerance,
                                   int32_t                               u_q31);

/// Writes the functions of the feed-forward without a force sensor, likewise.
void tribo_sensorless_q31_method(tribo_force_loop_q31_functions_t *functions);

#ifdef __cplusplus
}
#endif

#endif
