/// Friction compensation by feed-forward from the reversals of the reference, with learned breakaway, single precision.
///
/// Friction opposes the motion commanded by the reference r, so it is fed forward with r instead of being estimated from u:
///
///     r --> reachable r --> play of width w --> sign, +1 or -1 --> sigma, a ramp of T_j --> f = L+ or -L-
///               |  '--> rate ------------------------------------> lin = r + lead (1/p_a + b/K) rate
///               v
///     reference model (reference_model_f32.h), driven by lin --> y expected         e = y expected - y
///
///     u = limit(v + lin + f - b)          v = K(z) e, the controller
///
/// L+ and L- are learned while the arm slides (friction_observer_f32.h, breakaway_learning_f32.h). f depends only on r and on
/// slowly learned numbers: no fast path through u can chatter. The offset b absorbs the controller's integral wound up during
/// stiction (at a reversal) and changes of f by learning (so that learning never moves u). It decays with T_b.
///
/// A tick has three calls, with the controller between them:
///
///     e     = tribo_feedforward_f32_before(r, y)
///     v     = the controller's output for e
///     added = tribo_feedforward_f32_added(v)              u = limit(v + added), anti-windup as usual
///     tribo_feedforward_f32_after(v, u, limited)
///
/// Once r has stood for a while, friction is fed back instead (hold_f32.h): r announces neither a stuck step nor a moving
/// environment. u does not jump where this begins or ends.
///
/// The friction params give the prior L(F), by law or table; a constant load (gravity) is learned as a difference of L+ and L-.
/// Without gravity, forces times 2 or mirrored give the same bits (tests/contract).
/// A tick has two divisions, three while sigma ramps, four in a hold, five where it learns, and one or two more with a table.
/// The tick that learns is the longest, by half (docs/numbers.md). Not synchronized: one state, one tick.

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

typedef struct
{
    float                  actuator_pole_rad_per_s; ///< over 0; pole times sample time at most 50
    float                  sensor_pole_rad_per_s;   ///< likewise
    tribo_arm_f32_config_t arm;
} tribo_reference_model_f32_config_t;

/// Constants of a step, made by tribo_reference_model_f32_init. Const from then on; may be shared.
typedef struct
{
    float                  actuator_part, sensor_part; ///< step response after a tick, 1 - e^(-p h)
    tribo_arm_f32_params_t arm;
} tribo_reference_model_f32_params_t;

/// Distances from r.
typedef struct
{
    float                 actuator_n; ///< behind the actuator's pole
    tribo_arm_f32_state_t arm;
    float                 sensor_n; ///< behind the sensor's pole: y expected minus r
} tribo_reference_model_f32_state_t;

/// Constants of a step, made by tribo_friction_observer_f32_init. Const from then on; may be shared.
typedef struct
{
    float actuator_part, sensor_part; ///< of reference_model_f32.h
    float filter_part;                ///< h/(T_y + h)
    float damping;                    ///< b/(K h)
} tribo_friction_observer_f32_params_t;

/// All except y are distances from y, so that a low pass keeps the last bits of a constant force.
typedef struct
{
    float y_n;                  ///< the last reading
    float actuator_n, sensor_n; ///< u behind the actuator's pole, and behind the sensor's too
    float behind_n;             ///< LP(y)
    float difference_n;         ///< LP(u2 - y)
} tribo_friction_observer_f32_state_t;

/// Measurement of one step.
typedef struct
{
    float friction_n; ///< z
    float force_n;    ///< LP(y), to which z belongs
    float change_n;   ///< of LP(y) in this tick: y' h
} tribo_friction_observer_f32_signals_t;

/// Directions, as in the laws of friction_f32.h.
#define TRIBO_BREAKAWAY_POSITIVE 0u
#define TRIBO_BREAKAWAY_NEGATIVE 1u

/// Consecutive slides in one direction that end at a bound until stays_at_bound latches.
#define TRIBO_BREAKAWAY_BOUND_SLIDES 4u

typedef struct
{
    float scale_sd;          ///< prior standard deviation of the scale, 1e-3 to 2
    float offset_sd_n;       ///< prior standard deviation of the offset, 1e-9 to 1e6 N
    float correlation;       ///< of the directions before anything is learned, 0 to 0.99
    float correlation_faded; ///< of the directions once forgotten, 0 to 0.99
    float trust;             ///< weight of the prior before anything is learned, 0 to 1
    float
        relative_variance; ///< before anything is learned, 1e-3 to 1: 1, or the remaining one if the prior was learned
    float weight_n; ///< of a measurement: distance over which noise averages out, 1e-9 to 1e6 N; larger is slower
    float forgetting_per_n; ///< fraction of the prior's relative variance regained per newton, 0 to 1e6 1/N
    float scale_min;        ///< L stays above this fraction of the prior, 1e-3 to 1
    float scale_max;        ///< L stays below this multiple of the prior, 1 to 10
} tribo_breakaway_learning_f32_config_t;

/// Constants of a step, made by tribo_breakaway_learning_f32_init. Const from then on; may be shared.
typedef struct
{
    float scale_most, offset_most_n;   ///< three standard deviations
    float scale_variance;              ///< of the prior
    float offset_variance;             ///< of the prior, N^2
    float scale_shared, offset_shared; ///< of both directions once forgotten
    float correlation;                 ///< of the directions before anything is learned
    float relative_variance;           ///< before anything is learned
    float distrust;                    ///< 1 - trust
    float weight_n;
    float forgetting_per_n;
    float scale_min, scale_max;
} tribo_breakaway_learning_f32_params_t;

/// Learned scale and offset of one direction, and their covariance.
typedef struct
{
    float scale, offset_n; ///< within three standard deviations
    float ss, so, oo;      ///< scale with scale, with offset, offset with offset
} tribo_breakaway_learned_f32_t;

/// The learned state for the other sign of F.
typedef struct
{
    tribo_breakaway_learned_f32_t of[2];
    float                         shared[4];
    float                         travel_n[2];
} tribo_breakaway_across_f32_t;

typedef struct
{
    tribo_breakaway_learned_f32_t of[2]; ///< the directions
    float   shared[4];                   ///< covariance: L+'s scale with L-'s, with its offset; L+'s offset likewise
    float   travel_n[2];       ///< learned from, by direction; stops once a tick's travel is below its last bit
    uint8_t slid;              ///< 1: something was learned since the last slide ended
    uint8_t bound_slides[2];   ///< consecutive slides that ended at a bound, by direction; stops at 255
    uint8_t stays_at_bound[2]; ///< 1: TRIBO_BREAKAWAY_BOUND_SLIDES of them were seen; latched until reset or restore
    tribo_breakaway_across_f32_t across;
} tribo_breakaway_learning_f32_state_t;

/// Values at a force that follow from the prior alone.
typedef struct
{
    float prior_n;
    float variance; ///< of L before anything is learned, N^2
} tribo_breakaway_learning_f32_place_t;

/// L in one direction at one force.
typedef struct
{
    float L_n;               ///< estimate, within scale_min to scale_max of the prior
    float relative_variance; ///< 0 to 1, except for rounding
    float weighted_n;        ///< (1 - (1 - trust) relative variance) L
} tribo_breakaway_learning_f32_signals_t;

typedef struct
{
    float gain;            ///< E, 0 to 0.99; 0: never
    float still_time_s;    ///< the reference stands after this time without motion, 1e-6 to 1e3 s
    float margin;          ///< B over L, 0.1 to 1
    float quick_time_s;    ///< between changes of sign that count as chatter, 1e-6 to 1e3 s
    float margin_travel_n; ///< learning travel over which the extra margin fades, 1e-9 to 1e6 N
    float deadband_time_s; ///< of the filters of the deadband, 1e-6 to 1e3 s
} tribo_hold_f32_config_t;

/// Constants of a step, made by tribo_hold_f32_init. Const from then on; may be shared.
typedef struct
{
    bool     on;
    uint32_t still_ticks, quick_ticks;
    float    gain, margin;
    float    extra_margin_per_n;
    float    deadband_part;
} tribo_hold_f32_params_t;

typedef struct
{
    uint8_t                active;       ///< 0 or 1
    uint8_t                quick;        ///< changes of sign in quick succession, up to 4
    float                  anchor_n;     ///< the standing reference
    uint32_t               still;        ///< ticks of standing, up to still_ticks
    uint32_t               since;        ///< ticks since the last change of sign, up to quick_ticks
    float                  extra_margin; ///< 0 to 1
    tribo_play_f32_state_t play;         ///< the arm's force, and the sign of u relative to it
    float                  error_n;      ///< filtered error
    float                  y_n[2];       ///< the last reading, and the one before
    float                  noise_n;      ///< mean second difference of y, 0 in ticks without a change of y
    float                  changed;      ///< fraction of ticks in which y changed
} tribo_hold_f32_state_t;

/// Unless stated otherwise, forces in N are 1e-9 to 1e6 and times in s 1e-6 to 1e3.
typedef struct
{
    float actuator_pole_rad_per_s; ///< p_a, see reference_model_f32.h
    float sensor_pole_rad_per_s;   ///< p_s
    float reversal_n;              ///< w, width of a reversal of r; the error at one is at least about w
    float jump_time_s;             ///< T_j, of a reversal of f; shorter than a tick: at once
    float lead;         ///< 0 to 1; fraction of the plant's lag compensated by the rate of r; 0: the rate is not used
    float noise_gain;   ///< k_n, 0 to 8; widens w by the noise of r, 0 for a clean r
    float noise_time_s; ///< T_n, averaging time of the noise of r
    float rate_time_s;  ///< T_r, of the filter of the rate
    float rate_max_n_per_s;       ///< a faster r is a step; 1e-6 to 1e9 N/s
    float offset_time_s;          ///< T_b, decay time of b
    float slide_width_n;          ///< w_y, of the play that separates travel of y from noise
    float slide_filter_time_s;    ///< T_y, of friction observer and slide detector, 1e-6 to 10 s
    float slide_rate_max_n_per_s; ///< no learning from a faster y; 1e-6 to 1e9 N/s
    float slide_run_in_n;         ///< d_s, travelled before learning begins; also averages v over slides
    float slide_error_max_n;      ///< e_g, of the filtered error: beyond it, F does not track r
    tribo_breakaway_learning_f32_config_t learning;
    tribo_hold_f32_config_t               hold;
} tribo_feedforward_f32_config_t;

/// Constants of a tick, made by tribo_feedforward_f32_init. Const from then on; may be shared.
typedef struct
{
    tribo_force_loop_f32_method_t         method; ///< for a loop with the feed-forward
    tribo_reference_model_f32_params_t    reference_model;
    tribo_friction_observer_f32_params_t  observer;
    tribo_breakaway_learning_f32_params_t learning;
    tribo_hold_f32_params_t               hold;
    float                                 input_max_n;
    float                                 offset_max_n; ///< of |b| and of its terms
    float                                 reversal_n;   ///< w
    float                                 jump;         ///< of sigma a tick, 2 h/T_j up to 2
    float                                 lead_s;       ///< lead (1/p_a + b/K)
    float                                 noise_gain, noise_part;
    float noise_floor_n; ///< added to the limit of second differences that count as noise
    float rate_hz;       ///< 1/h
    float rate_part;
    float step_n;      ///< a larger change of r in a tick is a step
    float offset_part; ///< h/T_b
    float slide_half_n;
    float slide_change_max_n; ///< of LP(y) in a tick
    float slide_run_in_n;
    float slide_error_max_n;
} tribo_feedforward_f32_params_t;

typedef struct
{
    uint8_t                              running;    ///< 0 before the first tick
    uint8_t                              entering;   ///< 1: the next tick adds entry_n
    int8_t                               limited;    ///< sign of the limit that u met in the last tick, or 0
    float                                entry_n;    ///< see tribo_feedforward_f32_enter
    float                                r_n[2];     ///< last good r, and the one before
    float                                noise_n;    ///< n_r, mean second difference of r
    float                                reached_n;  ///< rs, r as far as the limits of u allow
    float                                rate_n_s;   ///< filtered rate of rs
    float                                side;       ///< sign of F for which the active side learns, -1 or 1
    float                                sigma;      ///< -1 to 1: f is -L- to L+
    float                                u_n;        ///< as applied in the last tick
    float                                f_n;        ///< fed forward in the last tick
    float                                e_n;        ///< error in the last tick
    float                                added_n;    ///< lin + f - b in the last tick
    float                                offset_n;   ///< b
    float                                held_n[2];  ///< vh, mean v - b in slides of each direction
    float                                error_n;    ///< LP(e)
    float                                distance_n; ///< D, travelled without a break
    float                                fade;       ///< of f, by a guard, 0 to 1
    uint32_t                             bad_inputs; ///< ticks with a bad r or y since reset; stops at UINT32_MAX
    tribo_play_f32_state_t               reversal;   ///< rp and s
    tribo_play_f32_state_t               slide;      ///< m and dir
    tribo_reference_model_f32_state_t    reference_model;
    tribo_friction_observer_f32_state_t  observer;
    tribo_breakaway_learning_f32_state_t learning;
    tribo_hold_f32_state_t               hold;
} tribo_feedforward_f32_state_t;

/// Signals of one tick, for logging and between its three calls: pass the same struct to all.
typedef struct
{
    float                                  e_n;       ///< error, y expected - y; 0 with a bad y
    float                                  y_n;       ///< y, or the last good one
    float                                  reached_n; ///< rs
    float                                  lin_n;     ///< force without friction for the reference
    float                                  f_n;       ///< friction fed forward
    float                                  b_n;       ///< offset in this tick
    float                                  added_n;   ///< lin + f - b
    float                                  sigma;     ///< direction of f, -1 to 1
    float                                  travel_n;  ///< learned from in this tick
    tribo_breakaway_learning_f32_place_t   place;     ///< rs, for the sign of r
    tribo_breakaway_learning_f32_signals_t ahead;     ///< L of the sign of r, at rs
    tribo_breakaway_learning_f32_signals_t behind;    ///< of the other sign while sigma ramps from it, else 0
    tribo_friction_observer_f32_signals_t  observer;
    int8_t                                 sign;   ///< s, the sign of r
    bool                                   turns;  ///< a reversal that the offset answers
    bool                                   leaves; ///< the first tick after a hold: u continues
    bool                                   y_good; ///< learning is allowed
    bool                                   r_good;
} tribo_feedforward_f32_signals_t;

/// Learned breakaway in one direction.
typedef struct
{
    float L_n;               ///< estimate at some force
    float relative_variance; ///< 0 to 1: remaining fraction of the prior's variance there
    float travel_n;          ///< learned from
    bool  at_bound; ///< do not trust L: the prior is too wrong for the params, or the measurement is not friction
    bool
        stays_at_bound; ///< four consecutive slides ended so; latched until reset or tribo_breakaway_learning_f32_restore
} tribo_feedforward_f32_learned_t;

/// Memory of a feed-forward, attached to a loop.
typedef struct
{
    tribo_feedforward_f32_state_t   state;
    tribo_feedforward_f32_signals_t signals; ///< of the last tick, for logging
} tribo_feedforward_f32_memory_t;

/// Defaults, for forces about 1 N and the paper's poles.
tribo_feedforward_f32_config_t tribo_feedforward_f32_default(void);

/// Checks `config` field by field and computes `params`; the arm is that of `model`. Returns TRIBO_OK, TRIBO_ERR_NULL,
/// TRIBO_ERR_SAMPLE_TIME, TRIBO_ERR_INPUT_MAX, or the status of a row of TRIBO_ARM_, _FEEDFORWARD_, _LEARNING_ or
/// _HOLD_PARAMETERS. Writes nothing unless TRIBO_OK. It leaves params.method empty: a loop runs only params that
/// tribo_force_loop_feedforward_f32_init has made. Not for the tick.
tribo_status_t tribo_feedforward_f32_init(tribo_feedforward_f32_params_t       *params,
                                          const tribo_feedforward_f32_config_t *config,
                                          const tribo_compensator_f32_config_t *model,
                                          float                                 input_max_n,
                                          float                                 sample_time_s);

/// Nothing learned, counter 0; the next tick is the first.
void tribo_feedforward_f32_reset(const tribo_feedforward_f32_params_t *params, tribo_feedforward_f32_state_t *state);

/// Learned breakaway in `direction` (TRIBO_BREAKAWAY_POSITIVE or _NEGATIVE) at the end-point force `force_n`. A bad force
/// counts as 0. Not for every tick.
tribo_feedforward_f32_learned_t tribo_feedforward_f32_learned(const tribo_feedforward_f32_params_t *params,
                                                              const tribo_friction_f32_params_t    *friction,
                                                              const tribo_feedforward_f32_state_t  *state,
                                                              uint32_t                              direction,
                                                              float                                 force_n);

/// Clears bound_slides and stays_at_bound; learned values stay.
void tribo_breakaway_learning_f32_restore(tribo_breakaway_learning_f32_state_t *state);

/// The feed-forward as a method of the force loop, for params made on a host.
#define TRIBO_FEEDFORWARD_F32_METHOD                                                                                   \
    {.error    = tribo_feedforward_f32_method_error,                                                                   \
     .friction = tribo_feedforward_f32_method_friction,                                                                \
     .term     = tribo_feedforward_f32_method_term,                                                                    \
     .after    = tribo_feedforward_f32_method_after,                                                                   \
     .last     = tribo_feedforward_f32_method_last,                                                                    \
     .enter    = tribo_feedforward_f32_method_enter}

float tribo_feedforward_f32_method_error(const tribo_force_loop_f32_params_t *params,
                                         void                                *memory,
                                         float                                r_n,
                                         float                                y_n,
                                         float                                fade);
float tribo_feedforward_f32_method_friction(const void *memory);
float tribo_feedforward_f32_method_term(const tribo_force_loop_f32_params_t *params, void *memory, float v_n);
void  tribo_feedforward_f32_method_after(const tribo_force_loop_f32_params_t *params,
                                         void                                *memory,
                                         float                                v_n,
                                         float                                u_n,
                                         tribo_force_loop_f32_signals_t      *signals);
void  tribo_feedforward_f32_method_last(const void *memory, tribo_force_loop_f32_last_t *last);
void  tribo_feedforward_f32_method_enter(void *memory, float term_n, bool anew);

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
    const bool is_one = params->method != NULL && params->method->enter == tribo_feedforward_f32_method_enter;
    return is_one ? (const tribo_feedforward_f32_params_t *)params->method : NULL; // its first member
}

/// Call after a reset of `state`: `memory` restarts with it, but keeps learned values. Reset `memory` once before; it must
/// outlive `state`. Null: none.
void tribo_force_loop_feedforward_f32_attach(tribo_force_loop_f32_state_t   *state,
                                             tribo_feedforward_f32_memory_t *memory);

/// Data of a rig.
typedef struct
{
    float                              actuator_pole_rad_per_s, sensor_pole_rad_per_s;
    const tribo_arm_f32_config_t      *arm;
    const tribo_friction_f32_params_t *friction; ///< the model's breakaway
    float                              input_max_n;
    float                              noise_n; ///< standard deviation of y; 0 if unknown
    float                              sample_time_s;
} tribo_feedforward_f32_rig_t;

/// Checks nothing: tribo_feedforward_f32_init and tribo_guard_f32_init refuse impossible values.
tribo_feedforward_f32_config_t tribo_feedforward_f32_tuned(const tribo_feedforward_f32_rig_t *rig);
tribo_guard_f32_config_t       tribo_guard_f32_tuned(const tribo_feedforward_f32_rig_t *rig);

#ifdef __cplusplus
}
#endif

#endif
