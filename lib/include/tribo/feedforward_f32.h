/// Friction compensation by feed-forward from the reversals of the reference, with learned breakaway, single precision.
///
/// Friction opposes the motion that the reference r asks for, so it is fed forward with r instead of being estimated from u:
///
///     r --> reachable r --> play of width w --> way, +1 or -1 --> sigma, a ramp of T_j --> f = L+ or -L-
///               |  '--> rate ------------------------------------> lin = r + lead (1/p_a + b/K) rate
///               v
///     path without friction (path_f32.h), driven by lin --> y expected         e = y expected - y
///
///     u = limit(v + lin + f - b)          v = K(z) e, the controller
///
/// L+ and L- are learned while the arm slides (friction_meter_f32.h, breakaway_learning_f32.h). f depends on r and on slowly
/// learned numbers only: there is no fast path through u that could chatter. The offset b takes up what the controller wound
/// up while the force stood (at a reversal) and what learning moves f by (so that learning never moves u); it leaks away
/// with T_b.
///
/// A tick has three calls, with the controller between them:
///
///     e     = tribo_feedforward_f32_before(r, y)
///     v     = the controller's output for e
///     added = tribo_feedforward_f32_added(v)              u = limit(v + added), anti-windup as ever
///     tribo_feedforward_f32_after(v, u, limited)
///
/// While r stands for a while, friction is fed back instead (hold_f32.h): a step of r that stuck and an environment that moves
/// are not announced. u does not jump where it begins or ends.
///
/// The friction params give the prior L(F), by law or table; a constant load (gravity) is learned as a difference of L+ and L-.
/// All forces times 2, or mirrored, give the same bits but for that (tests/contract).
/// A tick has two divisions, three where f changes over, four in a hold, five where it learns, and one or two more with a table.
/// The tick that learns is the longest, by half (docs/numbers.md). Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_F32_H
#define TRIBO_FEEDFORWARD_F32_H

#include "tribo/breakaway_learning_f32.h"
#include "tribo/compensator_f32.h"
#include "tribo/friction_meter_f32.h"
#include "tribo/hold_f32.h"
#include "tribo/path_f32.h"
#include "tribo/play_f32.h"
#include "tribo/status.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Forces in N are 1e-9 to 1e6, times in s 1e-6 to 1e3 unless something else is said.
typedef struct
{
    float actuator_pole_rad_per_s; ///< p_a, see path_f32.h
    float sensor_pole_rad_per_s;   ///< p_s
    float reversal_n;              ///< w, width of a reversal of r; the error at one is at least about w
    float jump_time_s;             ///< T_j, of a reversal of f; shorter than a tick: at once
    float lead;                ///< 0 to 1; share of the path's lag that the rate of r makes up for; 0: no rate is used
    float noise_gain;          ///< k_n, 0 to 8; widens w by the noise of r, 0 for a clean r
    float noise_time_s;        ///< T_n, over which the noise of r is averaged
    float rate_time_s;         ///< T_r, of the filter of the rate
    float rate_max_n_per_s;    ///< a faster r is a step; 1e-6 to 1e9 N/s
    float offset_time_s;       ///< T_b, with which b leaks away
    float slide_width_n;       ///< w_y, of the play that tells travel of y from noise
    float slide_filter_time_s; ///< T_y, of friction meter and slide detector, 1e-6 to 10 s
    float slide_rate_max_n_per_s; ///< nothing is learned from a faster y; 1e-6 to 1e9 N/s
    float slide_run_in_n;         ///< d_s, travelled before learning begins; also averages v over slides
    float slide_error_max_n;      ///< e_g, of the filtered error: beyond it, F is not where r is
    tribo_breakaway_learning_f32_config_t learning;
    tribo_hold_f32_config_t               hold;
} tribo_feedforward_f32_config_t;

/// What a tick reads, made by tribo_feedforward_f32_init. Const from then on; may be shared.
typedef struct
{
    tribo_path_f32_params_t               path;
    tribo_friction_meter_f32_params_t     meter;
    tribo_breakaway_learning_f32_params_t learning;
    tribo_hold_f32_params_t               hold;
    float                                 input_max_n;
    float                                 offset_max_n; ///< |b| and what it is made of
    float                                 reversal_n;   ///< w
    float                                 jump;         ///< of sigma a tick, 2 h/T_j up to 2
    float                                 lead_s;       ///< lead (1/p_a + b/K)
    float                                 noise_gain, noise_part;
    float noise_floor_n; ///< added to the largest second difference that counts as noise
    float rate_hz;       ///< 1/h
    float rate_part;
    float step_n;      ///< change of r in a tick beyond which it is a step
    float offset_part; ///< h/T_b
    float slide_half_n;
    float slide_change_max_n; ///< of LP(y) in a tick
    float slide_run_in_n;
    float slide_error_max_n;
} tribo_feedforward_f32_params_t;

typedef struct
{
    uint8_t                              running;    ///< 0 before the first tick
    uint8_t                              entering;   ///< 1: the next tick is to add what entry_n says
    int8_t                               limited;    ///< side on which u was limited in the last tick, or 0
    float                                entry_n;    ///< see tribo_feedforward_f32_enter
    float                                r_n[2];     ///< last good r, and the one before
    float                                noise_n;    ///< n_r, mean second difference of r
    float                                reached_n;  ///< rs, r as far as u lets it be reached
    float                                rate_n_s;   ///< filtered rate of rs
    float                                side;       ///< of 0 that learning is on, -1 or 1
    float                                sigma;      ///< -1 to 1: f is -L- to L+
    float                                u_n;        ///< as applied in the last tick
    float                                f_n;        ///< fed forward in the last tick
    float                                offset_n;   ///< b
    float                                held_n[2];  ///< vh, mean v - b in slides of each direction
    float                                error_n;    ///< LP(e)
    float                                distance_n; ///< D, travelled without a break
    float                                share;      ///< of f that is fed forward, 0 to 1; a guard moves it
    uint32_t                             bad_inputs; ///< ticks with a bad r or y since reset; stops at UINT32_MAX
    tribo_play_f32_state_t               reversal;   ///< rp and s
    tribo_play_f32_state_t               slide;      ///< m and dir
    tribo_path_f32_state_t               path;
    tribo_friction_meter_f32_state_t     meter;
    tribo_breakaway_learning_f32_state_t learning;
    tribo_hold_f32_state_t               hold;
} tribo_feedforward_f32_state_t;

/// What one tick saw, for logging, and what its calls hand to each other: the same one for the three of them.
typedef struct
{
    float                                  e_n;       ///< error, y expected - y; 0 with a bad y
    float                                  y_n;       ///< y, or the last good one
    float                                  reached_n; ///< rs
    float                                  lin_n;     ///< force that the reference asks for
    float                                  f_n;       ///< friction fed forward
    float                                  b_n;       ///< offset in this tick
    float                                  added_n;   ///< lin + f - b
    float                                  sigma;     ///< direction of f, -1 to 1
    float                                  travel_n;  ///< learned from in this tick
    tribo_breakaway_learning_f32_place_t   place;     ///< rs, for the way that r goes
    tribo_breakaway_learning_f32_signals_t ahead;     ///< L of the way that r goes, at rs
    tribo_breakaway_learning_f32_signals_t behind;    ///< of the other one while f changes over from it, else 0
    tribo_friction_meter_f32_signals_t     meter;
    int8_t                                 way;    ///< s, the way that r goes
    bool                                   turns;  ///< a reversal that the offset answers
    bool                                   leaves; ///< the first tick after a hold: u goes on
    bool                                   y_good; ///< something may be learned
    bool                                   r_good;
} tribo_feedforward_f32_signals_t;

/// What was learned of breakaway in one direction.
typedef struct
{
    float L_n;      ///< estimate at some force
    float doubt;    ///< 0 to 1: how much of the prior's spread is left there
    float travel_n; ///< learned from
    bool
        at_bound; ///< the prior is further off than the params allow, or what is measured is not friction: not to be trusted
    bool
        stays_at_bound; ///< four slides in succession ended so; latched until reset or tribo_breakaway_learning_f32_restore
} tribo_feedforward_f32_learned_t;

/// Defaults, for forces about 1 N and the paper's poles.
tribo_feedforward_f32_config_t tribo_feedforward_f32_default(void);

/// Checks `config` field by field and computes `params`; the arm is that of `model`. Returns TRIBO_OK, TRIBO_ERR_NULL, what
/// tribo_path_f32_init, tribo_friction_meter_f32_init and tribo_breakaway_learning_f32_init say, TRIBO_ERR_INPUT_MAX or the
/// status of the first field that is wrong. Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_feedforward_f32_init(tribo_feedforward_f32_params_t       *params,
                                          const tribo_feedforward_f32_config_t *config,
                                          const tribo_compensator_f32_config_t *model,
                                          float                                 input_max_n,
                                          float                                 sample_time_s);

/// Nothing learned, counter 0; the next tick is the first.
void tribo_feedforward_f32_reset(const tribo_feedforward_f32_params_t *params, tribo_feedforward_f32_state_t *state);

/// The next tick is the first, for a controller that starts at rest; what was learned and the counter are kept.
void tribo_feedforward_f32_restart(tribo_feedforward_f32_state_t *state);

/// Like a restart, for a controller that goes on: the first tick adds `added_n` to v, which is what was added before, so
/// that u does not jump, and e is r - y. A bad `added_n` counts as 0.
void tribo_feedforward_f32_enter(tribo_feedforward_f32_state_t *state, float added_n);

/// What is known of breakaway in `direction` (TRIBO_BREAKAWAY_POSITIVE or _NEGATIVE) at the end-point force `force_n`. A bad
/// force counts as 0. Not for every tick.
tribo_feedforward_f32_learned_t tribo_feedforward_f32_learned(const tribo_feedforward_f32_params_t *params,
                                                              const tribo_friction_f32_params_t    *friction,
                                                              const tribo_feedforward_f32_state_t  *state,
                                                              uint32_t                              direction,
                                                              float                                 force_n);

/// First call of a tick: reference `r_n` and reading `y_n` in N give the error for the controller. `friction` gives the
/// prior. Cannot fail: a bad r (NaN, or beyond input_max_n) counts as the last good one, a bad y gives e = 0 and nothing is
/// learned; both are counted. `signals` must not be null, in all three calls.
float tribo_feedforward_f32_before(const tribo_feedforward_f32_params_t *params,
                                   const tribo_friction_f32_params_t    *friction,
                                   tribo_feedforward_f32_state_t        *state,
                                   float                                 r_n,
                                   float                                 y_n,
                                   tribo_feedforward_f32_signals_t      *signals);

/// Second call: what is to be added to the controller's output `v_n`. A NaN counts as 0.
float tribo_feedforward_f32_added(const tribo_feedforward_f32_params_t *params,
                                  tribo_feedforward_f32_state_t        *state,
                                  float                                 v_n,
                                  tribo_feedforward_f32_signals_t      *signals);

/// Last call, with `u_n` as applied, and whether the limit has acted. With a bad u (NaN, or beyond
/// TRIBO_F32_FORCE_MAX_N) or v nothing is measured or learned.
void tribo_feedforward_f32_after(const tribo_feedforward_f32_params_t *params,
                                 const tribo_friction_f32_params_t    *friction,
                                 tribo_feedforward_f32_state_t        *state,
                                 float                                 v_n,
                                 float                                 u_n,
                                 bool                                  limited,
                                 tribo_feedforward_f32_signals_t      *signals);

#ifdef __cplusplus
}
#endif

#endif
