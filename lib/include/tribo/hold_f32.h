/// Feedback of friction while the reference stands, single precision: what a feed-forward cannot know.
///
/// While the reference stands, a step that stuck or an environment that moves asks for motion that the reference does not announce.
/// Then friction is fed back, as the paper does it, with a play in place of its arm and relays:
///
///     force = min(u + B-, max(u - B+, force))      the arm's force, which follows u across the breakaway B
///     f     = gain (u - force)
///
/// with u of the last tick, and B the learned L less a margin, so that the loop's gain through it stays below 1. Should the play
/// chatter all the same, as with a breakaway much smaller than what was learned, the margin grows: after four changes of side
/// within quick_time_s of one another, caution += (1 - caution)/10 at each. Learning takes it back.
///
/// A deadband keeps the controller from following its own sensor's noise: what the filtered error is, up to a share of the mean
/// second difference of y, is taken from the error. It is smaller where y changes in every tick (noise that averages out) than
/// where it seldom does (a coarse converter).
/// No loops, one division. Not synchronized: one state, one tick.

#ifndef TRIBO_HOLD_F32_H
#define TRIBO_HOLD_F32_H

#include "tribo/play_f32.h"
#include "tribo/status.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct
{
    float gain;             ///< E, 0 to 0.99; 0: never
    float still_time_s;     ///< the reference stands when it has stood for that long, 1e-6 to 1e3 s
    float margin;           ///< B over L, 0.1 to 1
    float quick_time_s;     ///< between changes of side that count as chatter, 1e-6 to 1e3 s
    float caution_travel_n; ///< of learning, over which caution fades, 1e-9 to 1e6 N
    float deadband_time_s;  ///< of the filters of the deadband, 1e-6 to 1e3 s
} tribo_hold_f32_config_t;

/// What a step reads, made by tribo_hold_f32_init. Const from then on; may be shared.
typedef struct
{
    bool     on;
    uint32_t still_ticks, quick_ticks;
    float    gain, margin;
    float    caution_per_n;
    float    deadband_part;
} tribo_hold_f32_params_t;

typedef struct
{
    uint8_t                active;   ///< 0 or 1
    uint8_t                quick;    ///< changes of side in quick succession, up to 4
    float                  anchor_n; ///< where the reference stands
    uint32_t               still;    ///< ticks for which it has, up to still_ticks
    uint32_t               since;    ///< ticks since the last change of side, up to quick_ticks
    float                  caution;  ///< 0 to 1
    tribo_play_f32_state_t play;     ///< the arm's force, and the side of it on which u is
    float                  error_n;  ///< filtered error
    float                  y_n[2];   ///< the last reading, and the one before
    float                  noise_n;  ///< mean second difference of y, of ticks in which it changed, 0 in others
    float                  changed;  ///< share of ticks in which it did
} tribo_hold_f32_state_t;

/// The defaults of the design, for forces about 1 N.
tribo_hold_f32_config_t tribo_hold_f32_default(void);

/// Returns TRIBO_OK, TRIBO_ERR_NULL, TRIBO_ERR_SAMPLE_TIME, TRIBO_ERR_HOLD_GAIN, TRIBO_ERR_HOLD_TIME, TRIBO_ERR_HOLD_MARGIN,
/// TRIBO_ERR_HOLD_CAUTION or TRIBO_ERR_HOLD_DEADBAND. Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_hold_f32_init(tribo_hold_f32_params_t       *params,
                                   const tribo_hold_f32_config_t *config,
                                   float                          sample_time_s);

/// Not in hold, the reference just having come to `force_n`; no caution.
void tribo_hold_f32_reset(tribo_hold_f32_state_t *state, float force_n);

/// Whether the reference stands, i.e. has stayed within +-half_n of one place; a step of it while it stands counts as standing.
/// Cannot fail: with a bad input (NaN, or beyond TRIBO_F32_FORCE_MAX_N) it does not.
bool tribo_hold_f32_stands(const tribo_hold_f32_params_t *params,
                           tribo_hold_f32_state_t        *state,
                           float                          reference_n,
                           float                          half_n,
                           bool                           step);

/// Begins with friction `f_n` fed forward at `u_n`, of the last tick, on the side `way`, and with the reading `y_n`.
void tribo_hold_f32_enter(tribo_hold_f32_state_t *state, float u_n, float f_n, int32_t way, float y_n);

/// Friction to be added in this tick, from `u_n` of the last one and the learned breakaway. Cannot fail: with a bad input it is
/// what it was before.
float tribo_hold_f32_step(const tribo_hold_f32_params_t *params,
                          tribo_hold_f32_state_t        *state,
                          float                          u_n,
                          float                          positive_n,
                          float                          negative_n);

/// The error less the deadband. Cannot fail: a bad input gives `e_n` as it is.
float tribo_hold_f32_deadband(const tribo_hold_f32_params_t *params,
                              tribo_hold_f32_state_t        *state,
                              float                          e_n,
                              float                          y_n);

/// `travel_n` of slide was learned from.
void tribo_hold_f32_learned(const tribo_hold_f32_params_t *params, tribo_hold_f32_state_t *state, float travel_n);

#ifdef __cplusplus
}
#endif

#endif
