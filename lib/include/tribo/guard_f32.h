/// Guard against over-compensation, single precision: fades the friction that is added to u when it does harm.
///
/// It sees r, y and the friction f that the compensation adds to u, whatever the method. A play tells the turns of f from its
/// noise; from one turn to the next it takes
///
///     W = sum of f (dy - 2 dr)     work of f on the force, less twice what the reference asks for
///     the largest error e = r - y either way
///
/// and judges at the turn:
///
///     hunting      the last turn was less than quick_time_s ago, and W is over turn_n stray_n: f drives y where r does not go.
///                  16 in succession.
///     overshoot    the largest error was of the wrong sign, y beyond r the way that f pushes, by stray_n more than of the
///                  right one: F broke away before r asked for it, and further. 4 in succession.
///
/// An arm that is compensated too little breaks away late, with an error of the right sign, and its friction turns when r does,
/// at most a few times more. Over the closed-loop tables of docs/compensation.md no more than 8 turns and 2 overshoots follow
/// one another with the feed-forward; a loop that hunts has 10 to 30 turns a second.
///
/// The cause is latched, and the share of friction goes from 1 to 0 within fade_time_s; tribo_guard_f32_restore lets it back as slowly.
/// One product a tick, no loops. Not synchronized: one state, one tick.

#ifndef TRIBO_GUARD_F32_H
#define TRIBO_GUARD_F32_H

#include "tribo/guard.h"
#include "tribo/play_f32.h"
#include "tribo/status.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct
{
    float turn_n;       ///< f turns when it comes back by that much; 1e-9 to 1e6 N, about L/3
    float quick_time_s; ///< turns that are closer may be hunting, 1e-6 to 1e3 s and up to 1e5 samples
    float stray_n;      ///< of an overshoot, 1e-9 to 1e6 N, about L/15 and over twice the noise's peaks
    float fade_time_s;  ///< 1e-6 to 1e3 s
} tribo_guard_f32_config_t;

/// What a step reads, made by tribo_guard_f32_init. Const from then on; may be shared.
typedef struct
{
    float    half_n;
    float    stray_n;
    float    work_n2; ///< of hunting
    float    fade;    ///< of the share in a tick
    uint32_t quick_ticks;
} tribo_guard_f32_params_t;

typedef struct
{
    bool                   running;       ///< false before the first tick
    uint8_t                turns, strays; ///< in succession
    tribo_guard_cause_t    cause;         ///< latched
    float                  share;         ///< of friction, 0 to 1
    uint32_t               since;         ///< ticks since the last turn, up to quick_ticks
    float                  work_n2;       ///< W since then
    float                  high_n, low_n; ///< largest and smallest error since then, and 0
    float                  r_n, y_n;      ///< of the last tick
    tribo_play_f32_state_t play;          ///< of f
} tribo_guard_f32_state_t;

/// The defaults, for forces about 1 N.
tribo_guard_f32_config_t tribo_guard_f32_default(void);

/// Returns TRIBO_OK, TRIBO_ERR_NULL, TRIBO_ERR_SAMPLE_TIME, TRIBO_ERR_GUARD_TURN, TRIBO_ERR_GUARD_TIME or
/// TRIBO_ERR_GUARD_STRAY. Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_guard_f32_init(tribo_guard_f32_params_t       *params,
                                    const tribo_guard_f32_config_t *config,
                                    float                           sample_time_s);

/// Nothing seen, no cause, all friction.
void tribo_guard_f32_reset(tribo_guard_f32_state_t *state);

/// No cause any more; the share rises to 1 again, and what was seen is forgotten.
void tribo_guard_f32_restore(tribo_guard_f32_state_t *state);

/// Reference, reading, and the friction that is added to u in this tick; returns the share of friction for the next one. Cannot
/// fail: with a bad input (NaN, or beyond TRIBO_F32_FORCE_MAX_N) the share goes on and nothing is judged.
float tribo_guard_f32_step(const tribo_guard_f32_params_t *params,
                           tribo_guard_f32_state_t        *state,
                           float                           r_n,
                           float                           y_n,
                           float                           f_n);

#ifdef __cplusplus
}
#endif

#endif
