/// Friction compensation by feed-forward from the reversals of the reference, in fixed point: the twin of feedforward_f32.h.
///
/// Arguments and results are Q31 of one full scale FS, as in the rest of the library. Inside, forces are Q29 of FS, a quarter of
/// 32 bits, so that lin (within 1.5 FS), f and b (each within FS), and the difference of any two forces fit without a check. A
/// unit is 2^-29 FS, 4e-9 N at 2 N.
///
///     reversal and slide plays, filters, vh   Q29, rounded towards zero
///     noise of r                              Q37, up to FS/64
///     rate of r, a tick                       Q37, up to FS/128
///     b                                       Q61, so that its slow leak does not stop short
///     sigma                                   Q29, within +-1
///
/// Breakaway is learned in units of its prior standard deviations (breakaway_learning_q31.h). Mirrored inputs give mirrored bits;
/// all forces and FS times 2 give the same bits. e and the sum lin + f - b are limited to FS.
/// A tick has two divisions of 32 bits, three while sigma ramps, four in a hold or where it learns, and one or two more with
/// a table. The tick that learns is the longest, by half (docs/numbers.md). Not synchronized: one state, one tick.

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

/// Constants of a step, made by tribo_reference_model_q31_init.
typedef struct
{
    uint32_t               actuator_part, sensor_part; ///< 1 - e^(-p h), Q32
    tribo_arm_q31_params_t arm;
} tribo_reference_model_q31_params_t;

/// Distances from r.
typedef struct
{
    int32_t               actuator; ///< behind the actuator's pole
    tribo_arm_q31_state_t arm;
    int32_t               sensor;    ///< behind the sensor's pole: y expected minus r
    uint32_t              saturated; ///< since reset; stops at UINT32_MAX
} tribo_reference_model_q31_state_t;

/// Constants of a step, made by tribo_friction_observer_q31_init.
typedef struct
{
    uint32_t actuator_part, sensor_part; ///< of reference_model_q31.h
    uint32_t filter_part;                ///< h/(T_y + h), Q32
    uint32_t damping;                    ///< b/(K h) 2^-damping_shift, Q32
    int32_t  change_max;                 ///< 2^(30 - damping_shift)
    uint8_t  damping_shift;              ///< 0 to 15
} tribo_friction_observer_q31_params_t;

typedef struct
{
    int32_t actuator, sensor; ///< u behind the actuator's pole, and behind the sensor's too
    int32_t force;            ///< LP(y)
    int32_t difference;       ///< LP(u2 - y)
} tribo_friction_observer_q31_state_t;

/// Measurement of one step.
typedef struct
{
    int32_t friction; ///< z
    int32_t force;    ///< LP(y), to which z belongs
    int32_t change;   ///< of LP(y) in this tick: y' h
} tribo_friction_observer_q31_signals_t;

/// Constants of a step, made by tribo_breakaway_learning_q31_init.
typedef struct
{
    uint32_t scale_sd;          ///< Q32
    uint32_t offset_sd;         ///< in units
    int32_t  relative_variance; ///< before anything is learned, Q30
    int32_t  correlation;       ///< times that, Q30
    uint32_t correlation_faded; ///< Q32
    uint32_t distrust;          ///< 1 - trust, Q32
    uint32_t weight;            ///< in 1/16 units
    uint32_t forgetting;        ///< of a unit, Q56
    uint32_t scale_min;         ///< Q28
    uint32_t scale_max;         ///< Q28
} tribo_breakaway_learning_q31_params_t;

/// Learned scale and offset of one direction, and their covariance.
typedef struct
{
    int32_t scale, offset; ///< in prior standard deviations, Q28
    int32_t ss, so, oo;    ///< scale with scale, with offset, offset with offset, Q30
} tribo_breakaway_learned_q31_t;

/// The learned state for the other sign of F.
typedef struct
{
    tribo_breakaway_learned_q31_t of[2];
    int32_t                       shared[4];
    uint64_t                      travel[2];
} tribo_breakaway_across_q31_t;

typedef struct
{
    tribo_breakaway_learned_q31_t of[2]; ///< the directions
    int32_t  shared[4]; ///< covariance, Q30: L+'s scale with L-'s, with its offset; L+'s offset likewise
    uint64_t travel[2]; ///< learned from, by direction, in units
    uint8_t  slid, bound_slides[2], stays_at_bound[2]; ///< see the twin
    tribo_breakaway_across_q31_t across;
} tribo_breakaway_learning_q31_state_t;

/// Values at a force that follow from the prior alone.
typedef struct
{
    uint32_t l;        ///< prior, shifted left until it is between 1/2 and 1, Q31
    int32_t  a0, a1;   ///< standard deviations of scale and offset, shifted likewise
    uint32_t variance; ///< of L before anything is learned, Q28
    uint32_t inverse;  ///< 2^63 over the variance shifted left until its first bit is set
    uint8_t  shift;    ///< of l to Q29
    uint8_t  lift;     ///< of the variance
} tribo_breakaway_learning_q31_place_t;

/// L in one direction at one force, in units.
typedef struct
{
    uint32_t L;                 ///< estimate, within scale_min to scale_max of the prior, up to 2^29
    uint32_t relative_variance; ///< 0 to 1, Q31
    uint32_t weighted;          ///< (1 - (1 - trust) relative variance) L
} tribo_breakaway_learning_q31_signals_t;

/// Constants of a step, made by tribo_hold_q31_init.
typedef struct
{
    bool     on;
    uint32_t still_ticks, quick_ticks;
    uint32_t gain, margin;          ///< Q32
    uint32_t extra_margin_per_unit; ///< Q48
    uint32_t deadband_part;         ///< Q32
} tribo_hold_q31_params_t;

typedef struct
{
    uint8_t                active;       ///< 0 or 1
    uint8_t                quick;        ///< changes of sign in quick succession, up to 4
    int32_t                anchor;       ///< the standing reference
    uint32_t               still;        ///< ticks of standing, up to still_ticks
    uint32_t               since;        ///< ticks since the last change of sign, up to quick_ticks
    uint32_t               extra_margin; ///< Q32
    tribo_play_q31_state_t play;         ///< the arm's force, and the sign of u relative to it
    int32_t                error;        ///< filtered error
    int32_t                y[2];         ///< the last reading, and the one before
    uint32_t               noise;        ///< mean second difference of y, 0 in ticks without a change of y, 1/256 units
    uint32_t               changed;      ///< fraction of ticks in which y changed, Q32
} tribo_hold_q31_state_t;

/// Constants of a tick, made by tribo_feedforward_q31_init.
typedef struct
{
    tribo_force_loop_q31_method_t         method; ///< for a loop with the feed-forward
    tribo_reference_model_q31_params_t    reference_model;
    tribo_friction_observer_q31_params_t  observer;
    tribo_breakaway_learning_q31_params_t learning;
    tribo_hold_q31_params_t               hold;
    uint32_t                              input_max;  ///< Q31
    int32_t                               offset_max; ///< of |b| and of its terms, up to FS, Q29
    uint32_t                              reversal;   ///< w, Q29
    int32_t                               jump;       ///< of sigma a tick, Q29
    uint32_t                              lead;       ///< lead (1/p_a + b/K)/(256 h) 2^-lead_shift, Q32
    uint8_t                               lead_shift; ///< 0 to 8
    uint32_t                              noise_gain; ///< Q27
    uint32_t                              noise_part; ///< Q32
    uint32_t noise_floor;      ///< added to the limit of second differences that count as noise, Q37
    uint32_t rate_part;        ///< Q32
    int32_t  step;             ///< a larger change of r in a tick is a step, Q29
    int32_t  offset_part;      ///< h/T_b, Q32
    int32_t  slide_half;       ///< Q29
    int32_t  slide_change_max; ///< of LP(y) in a tick, up to 2^20 units
    uint32_t slide_run_in;     ///< Q29
    int32_t  slide_error_max;  ///< Q29
} tribo_feedforward_q31_params_t;

typedef struct
{
    uint8_t                              running;    ///< 0 before the first tick
    uint8_t                              entering;   ///< 1: the next tick adds entry
    int8_t                               limited;    ///< sign of the limit that u met in the last tick, or 0
    int32_t                              entry;      ///< see tribo_feedforward_q31_enter
    int32_t                              r[2];       ///< last good r, and the one before
    int32_t                              y;          ///< last good y
    uint32_t                             noise;      ///< n_r, mean second difference of r, Q37
    int32_t                              reached;    ///< rs, r as far as the limits of u allow
    int32_t                              rate;       ///< filtered change of rs in a tick, Q37
    int32_t                              side;       ///< sign of F for which the active side learns, -1 or 1
    int32_t                              sigma;      ///< Q29: f is -L- to L+
    int32_t                              u;          ///< as applied in the last tick
    int32_t                              f;          ///< fed forward in the last tick
    int32_t                              e;          ///< error in the last tick, Q31
    int32_t                              added;      ///< lin + f - b in the last tick, Q31
    int64_t                              offset;     ///< b, Q61
    int32_t                              held[2];    ///< vh, mean v - b in slides of each direction
    int32_t                              error;      ///< LP(e)
    uint32_t                             distance;   ///< D, travelled without a break
    uint32_t                             fade;       ///< of f, by a guard, Q32; UINT32_MAX is all of it
    uint32_t                             bad_inputs; ///< ticks with a bad r or y since reset; stops at UINT32_MAX
    tribo_play_q31_state_t               reversal;   ///< rp and s
    tribo_play_q31_state_t               slide;      ///< m and dir
    tribo_reference_model_q31_state_t    reference_model;
    tribo_friction_observer_q31_state_t  observer;
    tribo_breakaway_learning_q31_state_t learning;
    tribo_hold_q31_state_t               hold;
} tribo_feedforward_q31_state_t;

/// Signals of one tick, for logging and between its three calls: pass the same struct to all. Q29 unless stated otherwise.
typedef struct
{
    int32_t                                e;       ///< error, y expected - y, Q31; 0 with a bad y
    int32_t                                error;   ///< the same in Q29
    int32_t                                y;       ///< y, or the last good one
    int32_t                                reached; ///< rs
    int32_t                                lin;     ///< force without friction for the reference
    int32_t                                f;       ///< friction fed forward
    int32_t                                b;       ///< offset in this tick
    int32_t                                added;   ///< lin + f - b, Q31
    int32_t                                sigma;   ///< direction of f
    uint32_t                               travel;  ///< learned from in this tick
    tribo_breakaway_learning_q31_place_t   place;   ///< rs, for the sign of r
    tribo_breakaway_learning_q31_signals_t ahead;   ///< L of the sign of r, at rs
    tribo_breakaway_learning_q31_signals_t behind;  ///< of the other sign while sigma ramps from it, else 0
    tribo_friction_observer_q31_signals_t  observer;
    int8_t                                 sign;   ///< s, the sign of r
    bool                                   turns;  ///< a reversal that the offset answers
    bool                                   leaves; ///< the first tick after a hold: u continues
    bool                                   y_good; ///< learning is allowed
    bool                                   r_good;
} tribo_feedforward_q31_signals_t;

/// Learned breakaway in one direction.
typedef struct
{
    uint32_t L;                 ///< estimate at some force, Q29
    uint32_t relative_variance; ///< 0 to 1, Q31: remaining fraction of the prior's variance there
    uint64_t travel;            ///< learned from, Q29
    bool     at_bound; ///< do not trust L: the prior is too wrong for the params, or the measurement is not friction
    bool
        stays_at_bound; ///< four consecutive slides ended so; latched until reset or tribo_breakaway_learning_q31_restore
} tribo_feedforward_q31_learned_t;

/// Memory of a feed-forward, attached to a loop.
typedef struct
{
    tribo_feedforward_q31_state_t   state;
    tribo_feedforward_q31_signals_t signals; ///< of the last tick, for logging
} tribo_feedforward_q31_memory_t;

/// Returns TRIBO_OK, TRIBO_ERR_FULL_SCALE, or a status of tribo_feedforward_f32_init or of the parts' init functions. Writes
/// nothing unless TRIBO_OK. It leaves params.method empty, as tribo_feedforward_f32_init.
tribo_status_t tribo_feedforward_q31_init(tribo_feedforward_q31_params_t       *params,
                                          const tribo_feedforward_f32_config_t *config,
                                          const tribo_compensator_f32_config_t *model,
                                          float                                 input_max_n,
                                          float                                 sample_time_s,
                                          float                                 full_scale_n);

/// Nothing learned, counters 0; the next tick is the first.
void tribo_feedforward_q31_reset(const tribo_feedforward_q31_params_t *params, tribo_feedforward_q31_state_t *state);

/// Learned breakaway in `direction` (TRIBO_BREAKAWAY_POSITIVE or _NEGATIVE) at the end-point force `force`, Q31. Not for every
/// tick.
tribo_feedforward_q31_learned_t tribo_feedforward_q31_learned(const tribo_feedforward_q31_params_t *params,
                                                              const tribo_friction_q31_params_t    *friction,
                                                              const tribo_feedforward_q31_state_t  *state,
                                                              uint32_t                              direction,
                                                              int32_t                               force);

/// Clears bound_slides and stays_at_bound; learned values stay.
void tribo_breakaway_learning_q31_restore(tribo_breakaway_learning_q31_state_t *state);

/// The feed-forward as a method of the force loop, for params made on a host.
#define TRIBO_FEEDFORWARD_Q31_METHOD                                                                                   \
    {.error    = tribo_feedforward_q31_method_error,                                                                   \
     .friction = tribo_feedforward_q31_method_friction,                                                                \
     .term     = tribo_feedforward_q31_method_term,                                                                    \
     .after    = tribo_feedforward_q31_method_after,                                                                   \
     .last     = tribo_feedforward_q31_method_last,                                                                    \
     .enter    = tribo_feedforward_q31_method_enter}

int32_t tribo_feedforward_q31_method_error(const tribo_force_loop_q31_params_t *params,
                                           void                                *memory,
                                           int32_t                              r,
                                           int32_t                              y,
                                           uint32_t                             fade);
int32_t tribo_feedforward_q31_method_friction(const void *memory);
int32_t tribo_feedforward_q31_method_term(const tribo_force_loop_q31_params_t *params, void *memory, int32_t v);
void    tribo_feedforward_q31_method_after(const tribo_force_loop_q31_params_t *params,
                                           void                                *memory,
                                           int32_t                              v,
                                           int32_t                              u,
                                           tribo_force_loop_q31_signals_t      *signals);
void    tribo_feedforward_q31_method_last(const void *memory, tribo_force_loop_q31_last_t *last);
void    tribo_feedforward_q31_method_enter(void *memory, int32_t term, bool anew);

/// The feed-forward's params of a loop; null for another method.
static inline const tribo_feedforward_q31_params_t *tribo_feedforward_q31_of(
    const tribo_force_loop_q31_params_t *params)
{
    const bool is_one = params->method != NULL && params->method->enter == tribo_feedforward_q31_method_enter;
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

#ifdef __cplusplus
}
#endif

#endif
