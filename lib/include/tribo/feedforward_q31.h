/// Friction compensation by feed-forward from the reversals of the reference, in fixed point: the twin of feedforward_f32.h.
///
/// What the three calls take and return is Q31 of one full scale FS, as in the rest of the library. Inside, forces are Q29 of FS,
/// a quarter of 32 bits, so that lin (within 1.5 FS), f and b (each within FS), and the difference of any two forces fit without
/// a check. A unit is 2^-29 FS, 4e-9 N at 2 N.
///
///     reversal and slide plays, filters, vh   Q29, rounded towards zero
///     noise of r                              Q37, up to FS/64
///     rate of r, a tick                       Q37, up to FS/128
///     b                                       Q61, so that its slow leak does not stop short
///     sigma                                   Q29, within +-1
///
/// Breakaway is learned in units of its prior spread (breakaway_learning_q31.h). Mirrored inputs give mirrored bits; all forces
/// and FS times 2 give the same bits. e and the sum lin + f - b are limited to FS.
/// A tick has two divisions of 32 bits, three where f changes over, four in a hold or where it learns, and one or two more with
/// a table. The tick that learns is the longest, by half (docs/numbers.md). Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_Q31_H
#define TRIBO_FEEDFORWARD_Q31_H

#include "tribo/breakaway_learning_q31.h"
#include "tribo/friction_meter_q31.h"
#include "tribo/friction_q31.h"
#include "tribo/hold_q31.h"
#include "tribo/path_q31.h"
#include "tribo/play_q31.h"
#include "tribo/q31.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// What a tick reads, made by tribo_feedforward_q31_init (quantize_feedforward_q31.h).
typedef struct
{
    tribo_path_q31_params_t               path;
    tribo_friction_meter_q31_params_t     meter;
    tribo_breakaway_learning_q31_params_t learning;
    tribo_hold_q31_params_t               hold;
    uint32_t                              input_max;  ///< Q31
    int32_t                               offset_max; ///< |b| and what it is made of, up to FS, Q29
    uint32_t                              reversal;   ///< w, Q29
    int32_t                               jump;       ///< of sigma a tick, Q29
    uint32_t                              lead;       ///< lead (1/p_a + b/K)/(256 h) 2^-lead_shift, Q32
    uint8_t                               lead_shift; ///< 0 to 8
    uint32_t                              noise_gain; ///< Q27
    uint32_t                              noise_part; ///< Q32
    uint32_t noise_floor;      ///< added to the largest second difference that counts as noise, Q37
    uint32_t rate_part;        ///< Q32
    int32_t  step;             ///< change of r in a tick beyond which it is a step, Q29
    int32_t  offset_part;      ///< h/T_b, Q32
    int32_t  slide_half;       ///< Q29
    int32_t  slide_change_max; ///< of LP(y) in a tick, up to 2^20 units
    uint32_t slide_run_in;     ///< Q29
    int32_t  slide_error_max;  ///< Q29
} tribo_feedforward_q31_params_t;

typedef struct
{
    uint8_t                              running;    ///< 0 before the first tick
    uint8_t                              entering;   ///< 1: the next tick is to add what entry says
    int8_t                               limited;    ///< side on which u was limited in the last tick, or 0
    int32_t                              entry;      ///< see tribo_feedforward_q31_enter
    int32_t                              r[2];       ///< last good r, and the one before
    int32_t                              y;          ///< last good y
    uint32_t                             noise;      ///< n_r, mean second difference of r, Q37
    int32_t                              reached;    ///< rs, r as far as u lets it be reached
    int32_t                              rate;       ///< filtered change of rs in a tick, Q37
    int32_t                              side;       ///< of 0 that learning is on, -1 or 1
    int32_t                              sigma;      ///< Q29: f is -L- to L+
    int32_t                              u;          ///< as applied in the last tick
    int32_t                              f;          ///< fed forward in the last tick
    int64_t                              offset;     ///< b, Q61
    int32_t                              held[2];    ///< vh, mean v - b in slides of each direction
    int32_t                              error;      ///< LP(e)
    uint32_t                             distance;   ///< D, travelled without a break
    uint32_t                             share;      ///< of f, Q32; UINT32_MAX is all of it; a guard moves it
    uint32_t                             bad_inputs; ///< ticks with a bad r or y since reset; stops at UINT32_MAX
    tribo_play_q31_state_t               reversal;   ///< rp and s
    tribo_play_q31_state_t               slide;      ///< m and dir
    tribo_path_q31_state_t               path;
    tribo_friction_meter_q31_state_t     meter;
    tribo_breakaway_learning_q31_state_t learning;
    tribo_hold_q31_state_t               hold;
} tribo_feedforward_q31_state_t;

/// What one tick saw, for logging, and what its calls hand to each other: the same one for the three of them. Q29 where
/// nothing else is said.
typedef struct
{
    int32_t                                e;       ///< error, y expected - y, Q31; 0 with a bad y
    int32_t                                error;   ///< the same in Q29
    int32_t                                y;       ///< y, or the last good one
    int32_t                                reached; ///< rs
    int32_t                                lin;     ///< force that the reference asks for
    int32_t                                f;       ///< friction fed forward
    int32_t                                b;       ///< offset in this tick
    int32_t                                added;   ///< lin + f - b, Q31
    int32_t                                sigma;   ///< direction of f
    uint32_t                               travel;  ///< learned from in this tick
    tribo_breakaway_learning_q31_place_t   place;   ///< rs, for the way that r goes
    tribo_breakaway_learning_q31_signals_t ahead;   ///< L of the way that r goes, at rs
    tribo_breakaway_learning_q31_signals_t behind;  ///< of the other one while f changes over from it, else 0
    tribo_friction_meter_q31_signals_t     meter;
    int8_t                                 way;    ///< s, the way that r goes
    bool                                   turns;  ///< a reversal that the offset answers
    bool                                   leaves; ///< the first tick after a hold: u goes on
    bool                                   y_good; ///< something may be learned
    bool                                   r_good;
} tribo_feedforward_q31_signals_t;

/// What was learned of breakaway in one direction.
typedef struct
{
    uint32_t L;      ///< estimate at some force, Q29
    uint32_t doubt;  ///< 0 to 1, Q31: how much of the prior's spread is left there
    uint64_t travel; ///< learned from, Q29
    bool
        at_bound; ///< the prior is further off than the params allow, or what is measured is not friction: not to be trusted
    bool
        stays_at_bound; ///< four slides in succession ended so; latched until reset or tribo_breakaway_learning_q31_restore
} tribo_feedforward_q31_learned_t;

/// Nothing learned, counters 0; the next tick is the first.
void tribo_feedforward_q31_reset(const tribo_feedforward_q31_params_t *params, tribo_feedforward_q31_state_t *state);

/// The next tick is the first, for a controller that starts at rest; what was learned and the counters are kept.
void tribo_feedforward_q31_restart(tribo_feedforward_q31_state_t *state);

/// Like a restart, for a controller that goes on: the first tick adds `added`, Q31, to v, which is what was added before, so
/// that u does not jump, and e is r - y.
void tribo_feedforward_q31_enter(tribo_feedforward_q31_state_t *state, int32_t added);

/// What is known of breakaway in `direction` (TRIBO_BREAKAWAY_POSITIVE or _NEGATIVE) at the end-point force `force`, Q31. Not
/// for every tick.
tribo_feedforward_q31_learned_t tribo_feedforward_q31_learned(const tribo_feedforward_q31_params_t *params,
                                                              const tribo_friction_q31_params_t    *friction,
                                                              const tribo_feedforward_q31_state_t  *state,
                                                              uint32_t                              direction,
                                                              int32_t                               force);

/// First call of a tick: reference `r` and reading `y` give the error for the controller, all Q31. `friction` gives the prior.
/// Cannot fail: an r beyond input_max counts as the last good one, such a y gives e = 0 and nothing is learned; both are
/// counted. `signals` must not be null, in all three calls.
int32_t tribo_feedforward_q31_before(const tribo_feedforward_q31_params_t *params,
                                     const tribo_friction_q31_params_t    *friction,
                                     tribo_feedforward_q31_state_t        *state,
                                     int32_t                               r,
                                     int32_t                               y,
                                     tribo_feedforward_q31_signals_t      *signals);

/// Second call: what is to be added to the controller's output `v`, both Q31.
int32_t tribo_feedforward_q31_added(const tribo_feedforward_q31_params_t *params,
                                    tribo_feedforward_q31_state_t        *state,
                                    int32_t                               v,
                                    tribo_feedforward_q31_signals_t      *signals);

/// Last call, with `u` as applied, Q31, and whether the limit has acted.
void tribo_feedforward_q31_after(const tribo_feedforward_q31_params_t *params,
                                 const tribo_friction_q31_params_t    *friction,
                                 tribo_feedforward_q31_state_t        *state,
                                 int32_t                               v,
                                 int32_t                               u,
                                 bool                                  limited,
                                 tribo_feedforward_q31_signals_t      *signals);

#ifdef __cplusplus
}
#endif

#endif
