/// Friction compensation by feed-forward: a bank of stops driven by the reference, with learned weights, single precision.
///
/// Friction opposes the motion commanded by the reference r, so it is fed forward with r instead of being estimated from u:
///
///     r --> reachable r --> stops, and a ramp sigma at each reversal --> f = G (W0 sigma + W1 phi1 + ... + W4 phi4)
///               '--> rate ------------------------------------> lin, the force without friction
///     y expected, from lin by two low passes                            e = y expected - y
///
///     u = limit(v + lin + f + lead - b)          v = K(z) e, the controller
///
/// A stop is the force of an elastic element that slides at its width: together they are friction that builds up over distance.
/// The same stops, driven by y, teach the weights. f depends only on r and on slowly learned numbers: no fast path through u
/// can chatter. The offset b absorbs the controller's integral wound up during stiction (at a reversal) and changes of f by
/// learning, so that learning never moves u. Once r stands, friction is fed back instead: u does not jump where this begins or
/// ends. docs/feedforward.md has every step and constant.
///
/// The friction params give the prior L(F), by law or table. Forces times 2 (with all parameters in N) or mirrored, without
/// gravity, give the same bits (tests/contract).
/// A tick has at most seven divisions, one or two more with a table; learning is spread over ten ticks. No heap, no libm.
/// Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_F32_H
#define TRIBO_FEEDFORWARD_F32_H

#include "tribo/force_loop_f32.h"
#include "tribo/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TRIBO_FEEDFORWARD_STOPS 4u ///< beside sigma

/// Directions, as in the laws of friction_f32.h.
#define TRIBO_BREAKAWAY_POSITIVE 0u
#define TRIBO_BREAKAWAY_NEGATIVE 1u

#define TRIBO_FEEDFORWARD_BOUND_TURNS 4u ///< consecutive reversals at a bound of V_0 until it stays

/// Whether it stays, by `turns`, the state's at_bound.
static inline bool tribo_feedforward_stays_at_bound(uint8_t turns)
{
    return turns >= TRIBO_FEEDFORWARD_BOUND_TURNS;
}

typedef enum
{
    TRIBO_FEEDFORWARD_RESTART = 0, ///< the next good tick is the first, beside a controller at rest
    TRIBO_FEEDFORWARD_ENTER,       ///< likewise, beside a running controller: u goes on
    TRIBO_FEEDFORWARD_START,       ///< r has not moved yet: no direction, nothing learned
    TRIBO_FEEDFORWARD_MOVING,      ///< f follows r
    TRIBO_FEEDFORWARD_HOLD         ///< r stands: friction is fed back
} tribo_feedforward_mode_t;

/// How b gets its value in a tick.
typedef enum
{
    TRIBO_FEEDFORWARD_KEEP = 0,
    TRIBO_FEEDFORWARD_REVERSAL, ///< b = v, but for a part of the load
    TRIBO_FEEDFORWARD_CONTINUE, ///< u of the last tick goes on
    TRIBO_FEEDFORWARD_TAKE_OVER ///< the term of the last tick goes on
} tribo_feedforward_offset_t;

/// 0 where "derived" is said: computed by the init from breakaway, poles and arm.
typedef struct
{
    float actuator_pole_rad_per_s; ///< p_a, 1e-3 to 1e6; times sample time 1e-9 to 50
    float sensor_pole_rad_per_s;   ///< p_s, likewise
    float reversal_n;              ///< w, width of a reversal of r; the error at one is at least about w; 0: derived
    float presliding_n;            ///< d_4, travel of F over which friction builds up; 0: derived
    float jump_time_s;             ///< T_j, of a reversal of f; shorter than a tick: at once; 0: derived
    float jump_lead;               ///< alpha, 0 to 1; part of the actuator's lag that a jump of f leads by
    float trust;                   ///< gamma, 0 to 1; part of the prior that is used before anything is learned
    float forgetting_per_n;        ///< Q; part of the prior variance that returns per newton; 0: derived
    float still_time_s;            ///< T_q, 0 to 1e3; r stands after this time without motion; 0: never
} tribo_feedforward_f32_config_t;

/// Constants of a tick, made by tribo_feedforward_f32_init. Const from then on; may be shared.
typedef struct
{
    tribo_force_loop_f32_method_t method; ///< for a loop with the feed-forward
    float                         input_max_n;
    float                         offset_max_n;                         ///< of |b|
    float                         reversal_n;                           ///< w
    float                         stop_per_n[TRIBO_FEEDFORWARD_STOPS];  ///< 1/d_j
    float                         jump;                                 ///< of sigma a tick, 2 h/T_j up to 2
    float                         lead;                                 ///< alpha/(p_a h)
    float                         distrust;                             ///< 1 - gamma
    float                         lag_s;                                ///< tau
    float                         noise_part, noise_floor_n;            ///< h/T_n, n_0
    float                         rate_hz;                              ///< 1/h
    float                         rate_part;                            ///< h/(T_r + h)
    float                         step_n;                               ///< dr_s
    float                         lag_part, actuator_part, sensor_part; ///< h/(tau + h), E_pa, E_ps
    float                         observer_part;                        ///< h/(T_y + h)
    float                         damping;                              ///< b/(K h)
    float                         jump_lag;                             ///< T_z over the time of a sample
    float                         measured_per_n;                       ///< 1/d_0
    float                         travel_half_n;                        ///< w_y/2
    float                         slip_n;                               ///< travel of a sample that is one
    float                         travel_max_n;                         ///< delta_max
    float                         weighing_n;                           ///< R
    float                         doubt_per_n, margin_per_n;            ///< 1/D_t, 1/D_m
    float                         forgetting_per_n;                     ///< Q
    float                         constant_sd_n, constant_max_n;        ///< s_0, B
    uint32_t                      still_ticks, quick_ticks;             ///< 0 still_ticks: r never stands
    float                         deadband_part;                        ///< h/(T_d + h)
    float                         effort_part, effort_half_n;           ///< of v for the monitor; mu B/2
} tribo_feedforward_f32_params_t;

typedef struct
{
    float    anchor_n;     ///< a, the standing reference
    float    extra_margin; ///< lambda, 0 to 1
    float    error_n;      ///< filtered error, in a hold a step of r
    float    noise_n;      ///< mean second difference of y over ticks in which y changed
    float    changed;      ///< fraction of ticks in which y changed
    uint32_t still;        ///< ticks of standing, up to still_ticks
    uint32_t since;        ///< ticks since the last change of side, up to quick_ticks
    int8_t   side;         ///< of breakaway that friction reached last
    uint8_t  quick;        ///< changes of side in quick succession, up to 4
    uint8_t  rests;        ///< the error is within the noise, and u stays
} tribo_feedforward_hold_f32_state_t;

/// All except y are low passes.
typedef struct
{
    float y_n[2];               ///< the last good reading, and the one before
    float noise_n;              ///< n_y, mean second difference of y
    float actuator_n, sensor_n; ///< u_1, u_2
    float force_n;              ///< yf
    float difference_n;         ///< zf
    float friction_n;           ///< z
    float travelled_n;          ///< m
} tribo_feedforward_observer_f32_state_t;

typedef struct
{
    float    weight[1u + TRIBO_FEEDFORWARD_STOPS]; ///< V_j, of friction over the prior
    float    constant_n, slope, scale;             ///< c_0, c_1, c_2: load that does not reverse
    float    covariance[10]; ///< M of V_0, c_0, c_1, c_2 over their prior's: 00, 01, 02, 03, 11, 12, ...
    float    variance[TRIBO_FEEDFORWARD_STOPS]; ///< P_j, 0 to 1
    float    doubt;                             ///< 1 to 0
    float    travel_n;                          ///< learned from
    float    use[1u + TRIBO_FEEDFORWARD_STOPS]; ///< W_j, from the weights
    uint32_t seal;                              ///< of these numbers: one that does not fit is corrupt
} tribo_feedforward_weights_f32_t;

/// A sample, and what becomes of it.
typedef struct
{
    uint8_t  stage;                                    ///< 0 to 9
    int8_t   side;                                     ///< sign of the last move of m
    uint8_t  hunts;                                    ///< the last two changes of side were close
    uint32_t since;                                    ///< ticks since the last
    float    stop[1u + TRIBO_FEEDFORWARD_STOPS];       ///< X_j/d_j, -1 to 1
    float    travelled_n, force_n, friction_n, jump_n; ///< m, yf, z and its change
    float    sample_n;                                 ///< delta; 0: nothing to learn
    float    regressor[4 + TRIBO_FEEDFORWARD_STOPS];   ///< k_0 to k_3, kappa_j
    float    error, load;                              ///< epsilon; l
    float    weighing_n;                               ///< rho
    float    gain;
    float    presliding;                          ///< part of the stops' weights that is used
    float    gained[4 + TRIBO_FEEDFORWARD_STOPS]; ///< q
    uint32_t seal;                                ///< of delta, epsilon, rho, gain, q
} tribo_feedforward_learning_f32_state_t;

/// Friction fed back where fed forward it does harm.
typedef struct
{
    uint8_t harms;  ///< latched
    uint8_t left;   ///< n_f, reversals to be fed back
    uint8_t length; ///< n_l, of them in the last feedback, less those fed forward since
} tribo_feedforward_feedback_t;

/// What the controller does with friction fed forward, against what it would have to do without.
typedef struct
{
    float                        v_n, played_n, travel_n; ///< vf, vp, t_v
    float                        need_n;                  ///< at the last reversal
    float                        ratio;                   ///< xi, 0 to 4
    uint8_t                      begun;                   ///< r has moved since the start
    tribo_feedforward_feedback_t feedback;
} tribo_feedforward_monitor_f32_state_t;

typedef struct
{
    tribo_force_loop_f32_tick_t tick;        ///< what the loop reads
    uint8_t                     mode;        ///< tribo_feedforward_mode_t
    uint8_t                     offset_rule; ///< tribo_feedforward_offset_t
    uint8_t                     at_bound;    ///< reversals in succession with V_0 at a bound; 4 stays until restored
    int8_t                      sign;        ///< s, of r; 0: no direction yet
    int8_t                      limited;     ///< sign of the limit that u met in the last tick, or 0
    float                       r_n[2];      ///< the last good r, and the one before
    float                       noise_n;     ///< n_r, mean second difference of r
    float                       reached_n;   ///< rs, r as far as the limits of u allow
    float                       rate_n_s;    ///< filtered rate of rs
    float                       settled_n;   ///< rn, rs without its noise
    float                       turned_n;    ///< rp, rs behind a play of a reversal's width
    float                       stop[TRIBO_FEEDFORWARD_STOPS]; ///< phi_j, -1 to 1
    float                       sigma;                         ///< -1 to 1
    float                       behind_n[2];                   ///< m_1 and m_2 less rs
    float                       offset_n;                      ///< b
    uint32_t                    offset_seal;                   ///< of b from a tick to the next
    float                       f_n, u_n;                      ///< of the last tick
    float                       v_n;                           ///< low pass of v
    uint32_t                    forgotten; ///< times that a corrupt state was reset; stops at UINT32_MAX
    tribo_feedforward_hold_f32_state_t     hold;
    tribo_feedforward_observer_f32_state_t observer;
    tribo_feedforward_weights_f32_t        learned;
    tribo_feedforward_learning_f32_state_t learning;
    tribo_feedforward_monitor_f32_state_t  monitor;
} tribo_feedforward_f32_state_t;

/// Signals of one tick, for logging and between its three parts.
typedef struct
{
    float e_n;        ///< error, y expected - y; 0 with a bad y
    float y_n;        ///< y, or the last good one
    float reached_n;  ///< rs
    float load_n;     ///< of lin, what does not reverse
    float lin_n;      ///< force without friction for the reference
    float level_n;    ///< G
    float partial;    ///< W1 phi1 + ... + W4 phi4
    float f_n;        ///< friction fed forward, or back in a hold
    float lead_n;     ///< of a jump
    float b_n;        ///< offset
    float term_n;     ///< lin + f + lead - b, added to v
    float friction_n; ///< z, measured
    float travel_n;   ///< learned from, of the sample of this tick
    float need_n;     ///< f - b of the last tick
    bool  y_good;     ///< learning is allowed
    bool  flips;      ///< r reverses
} tribo_feedforward_f32_signals_t;

/// Learned breakaway in one direction.
typedef struct
{
    float    L_n;               ///< at some force: V_0 L, and what does not reverse
    float    relative_variance; ///< of L in this direction, over the prior's, at the force of the last sample
    float    travel_n;          ///< learned from, both ways; without a sensor widths of motion times reversal_n
    bool     at_bound;          ///< do not trust L: the prior is too wrong, or the measurement is not friction
    bool     stays_at_bound;    ///< four consecutive reversals found it so; latched until reset or restore
    bool     harms;     ///< friction fed forward cost more effort than it saved, and was fed back; latched likewise
    uint32_t forgotten; ///< times that a corrupt memory was reset, or its b set anew
} tribo_feedforward_f32_learned_t;

/// The work of another loop's effort over a slide. Travel is in widths of a reversal.
typedef struct
{
    float    moved, effort_n;       ///< motion of a tick, and u without the model's load; low passes
    float    slack;                 ///< of moved, in a play a width wide
    int8_t   side;                  ///< sign of the slide, 0: none yet
    uint32_t ticks;                 ///< of the slide; at its most, the slide does not count
    float    travel, work, prior;   ///< X, W, G
    float    last_travel;           ///< X', of the last slide that counted, with its sign
    float    last_work, last_prior; ///< a', l', a width
} tribo_feedforward_f32_effort_t;

/// Of a loop without a sensor.
typedef struct
{
    float                          slack[2];  ///< of a play a width wide, intended and measured
    int8_t                         sign;      ///< of the last motion, 0: none yet
    uint8_t                        is_known;  ///< in this tick
    uint8_t                        was_known; ///< in any tick: what is learned is used
    float                          measured;  ///< in this tick, widths
    tribo_feedforward_f32_effort_t effort;
} tribo_feedforward_f32_motion_t;

/// Memory of a feed-forward, attached to a loop.
typedef struct
{
    tribo_feedforward_f32_state_t   state;
    tribo_feedforward_f32_signals_t signals; ///< of the last tick, for logging
    tribo_feedforward_f32_motion_t  motion;
} tribo_feedforward_f32_memory_t;

/// Defaults, for the paper's poles.
tribo_feedforward_f32_config_t tribo_feedforward_f32_default(void);

/// Checks `config` field by field and computes `params`. Breakaway at `usual_force_n` sets all widths; `input_max_n` bounds what is
/// credible, and scales nothing else. Returns TRIBO_OK, TRIBO_ERR_NULL, TRIBO_ERR_SAMPLE_TIME, TRIBO_ERR_INPUT_MAX,
/// TRIBO_ERR_USUAL_FORCE, or the status of a row of TRIBO_FEEDFORWARD_PARAMETERS. Writes nothing unless TRIBO_OK. It leaves
/// params.method empty: a loop runs only params that tribo_force_loop_feedforward_f32_init has made. Not for the tick.
tribo_status_t tribo_feedforward_f32_init(tribo_feedforward_f32_params_t       *params,
                                          const tribo_feedforward_f32_config_t *config,
                                          const tribo_arm_f32_config_t         *arm,
                                          const tribo_friction_f32_params_t    *friction,
                                          float                                 input_max_n,
                                          float                                 usual_force_n,
                                          float                                 sample_time_s);

/// Nothing learned; the next good tick is the first.
void tribo_feedforward_f32_reset(tribo_feedforward_f32_state_t *state);

/// Learned breakaway in `direction` (TRIBO_BREAKAWAY_POSITIVE or _NEGATIVE) at the end-point force `force_n`. A bad force
/// counts as 0. Not for every tick.
tribo_feedforward_f32_learned_t tribo_feedforward_f32_learned(const tribo_friction_f32_params_t   *friction,
                                                              const tribo_feedforward_f32_state_t *state,
                                                              uint32_t                             direction,
                                                              float                                force_n);

/// Unlatches stays_at_bound and harms, and feeds friction forward; learned values stay.
void tribo_feedforward_f32_restore(tribo_feedforward_f32_state_t *state);

/// Writes the functions of the feed-forward as a method of the force loop, for the first member of its params.
void tribo_feedforward_f32_method(tribo_force_loop_f32_functions_t *functions);

/// Makes `params` of a loop with the feed-forward, and `feedforward`, which must outlive them: they point to it. Returns
/// TRIBO_OK or a status of tribo_force_loop_f32_init, then of tribo_feedforward_f32_init. Writes nothing unless TRIBO_OK. Not
/// for the tick.
tribo_status_t tribo_force_loop_feedforward_f32_init(tribo_force_loop_f32_params_t        *params,
                                                     tribo_feedforward_f32_params_t       *feedforward,
                                                     const tribo_force_loop_f32_config_t  *config,
                                                     const tribo_feedforward_f32_config_t *feedforward_config);

/// The feed-forward's params of a loop; null for another method.
static inline const tribo_feedforward_f32_params_t *tribo_feedforward_f32_of(
    const tribo_force_loop_f32_params_t *params)
{
    const bool is_one = params->method != NULL && params->method->functions == tribo_feedforward_f32_method;
    return is_one ? (const tribo_feedforward_f32_params_t *)params->method : NULL; // its first member
}

/// Call after a reset of `state`: `memory` restarts with it, but keeps learned values. Reset `memory->state` once before; it
/// must outlive `state`. Null: none.
void tribo_force_loop_feedforward_f32_attach(tribo_force_loop_f32_state_t   *state,
                                             tribo_feedforward_f32_memory_t *memory);

/// Data of a rig.
typedef struct
{
    float                              actuator_pole_rad_per_s, sensor_pole_rad_per_s;
    const tribo_arm_f32_config_t      *arm;
    const tribo_friction_f32_params_t *friction; ///< the model's breakaway
    float usual_force_n;                         ///< |F| around which the rig works; breakaway there sets the widths
    float noise_n;                               ///< standard deviation of y; 0 if unknown
    float sample_time_s;
} tribo_feedforward_f32_rig_t;

/// Parameters for a rig, with the derived ones in numbers. Checks nothing: the init functions refuse impossible values.
tribo_feedforward_f32_config_t tribo_feedforward_f32_tuned(const tribo_feedforward_f32_rig_t *rig);

/// The guard's parameters for that rig.
tribo_guard_f32_config_t tribo_guard_f32_tuned(const tribo_feedforward_f32_rig_t *rig);

// --- without a force sensor -------------------------------------------------------------------------------------------
//
// For drives with current and encoder only:
//
//     u = limit(lin + f + lead - b)          f = belief V L(rs) sigma
//
// A method of the force loop: steps 2 to 6 with the stops left out, with the params and memory above. y is not used (give 0), and the
// controller's output is taken out of u. b is 0, or what u goes on from after a change of params or of V, and fades in a quarter of
// a second. It has no feedback: u is as right as V L is, so it believes low.
//
// r is the force that the arm shall have, or the effort of somebody else's position or velocity loop. With that, and wherever the
// motion is known better than by r, tell it: tribo_sensorless_f32_motion.
//
// V is 1 until then. From then on it is the weight V_0 that two slides teach, one in each direction: from one reversal to the next
// u does the work of friction and load, and of nothing else. tribo_feedforward_f32_learned shows it.
//
// No guard: it judges y. A corrupt memory is forgotten whole and counted. No loops, one division a tick, five at a reversal.

typedef struct
{
    float belief; ///< part of the believed breakaway that is fed forward, 0 to 1
} tribo_sensorless_f32_config_t;

/// The default: believes low.
tribo_sensorless_f32_config_t tribo_sensorless_f32_default(void);

/// Makes `params` as the feed-forward's init does, for a loop without a sensor; of `feedforward_config` it uses the actuator's pole,
/// reversal_n, jump_time_s and jump_lead. The memory is attached as the feed-forward's.
tribo_status_t tribo_force_loop_sensorless_f32_init(tribo_force_loop_f32_params_t        *params,
                                                    tribo_feedforward_f32_params_t       *feedforward,
                                                    const tribo_force_loop_f32_config_t  *config,
                                                    const tribo_feedforward_f32_config_t *feedforward_config,
                                                    const tribo_sensorless_f32_config_t  *sensorless_config);

/// Before a tick: the motion of the arm in it, intended and measured, each in widths of a reversal, e.g. a change of position over
/// the travel that is surely a reversal and no noise, or a speed times h over that. 0 where there is none. Friction opposes the
/// intended motion; while that is at rest, the measured. In a tick without this call, r decides. Friction never jumps between them.
///
/// Friction is learned where the measured motion slides to and fro by 16 widths or more and r is the effort of the loop that moves it, so
/// far as u is what the arm gets. Give 0 for it where a process opposes the motion. A tick of more than 1000 widths is taken for none.
void tribo_sensorless_f32_motion(tribo_feedforward_f32_memory_t *memory, float intended, float measured);

/// Of F, from u alone.
typedef struct
{
    uint32_t runs;
    float    lagged_n; ///< u behind the lag of actuator and arm
    float    force_n;  ///< F^: an arm that sticks within L
    float    low_n,
        high_n; ///< the same with L times (1 - tolerance) to (1 + tolerance): F is between, beside the lag's error
} tribo_force_estimate_f32_t;

/// One tick with `u_n` as applied, by the params of a loop with or without a sensor. From runs = 0 any F is possible. A tolerance
/// or a force that is not credible changes nothing.
void tribo_force_estimate_f32_step(const tribo_force_loop_f32_params_t  *params,
                                   const tribo_feedforward_f32_params_t *feedforward,
                                   tribo_force_estimate_f32_t           *estimate,
                                   float                                 tolerance,
                                   float                                 u_n);

/// Writes the functions of the feed-forward without a force sensor, likewise.
void tribo_sensorless_f32_method(tribo_force_loop_f32_functions_t *functions);

#ifdef __cplusplus
}
#endif

#endif
