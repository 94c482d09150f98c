/// Feedback of friction while the reference stands, in fixed point: the twin of hold_f32.h.
///
/// Forces are in one unit, within +-2^29 of them. Shares are Q32; products are rounded towards zero, so mirrored forces give
/// mirrored results. The deadband's filters stop short by less than 1/part units.
/// No loops, one division of 32 bits. Not synchronized: one state, one tick.

#ifndef TRIBO_HOLD_Q31_H
#define TRIBO_HOLD_Q31_H

#include "tribo/play_q31.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// What a step reads, made by tribo_hold_q31_init (quantize_feedforward_q31.h).
typedef struct
{
    bool     on;
    uint32_t still_ticks, quick_ticks;
    uint32_t gain, margin;     ///< Q32
    uint32_t caution_per_unit; ///< Q48
    uint32_t deadband_part;    ///< Q32
} tribo_hold_q31_params_t;

typedef struct
{
    uint8_t                active;  ///< 0 or 1
    uint8_t                quick;   ///< changes of side in quick succession, up to 4
    int32_t                anchor;  ///< where the reference stands
    uint32_t               still;   ///< ticks for which it has, up to still_ticks
    uint32_t               since;   ///< ticks since the last change of side, up to quick_ticks
    uint32_t               caution; ///< Q32
    tribo_play_q31_state_t play;    ///< the arm's force, and the side of it on which u is
    int32_t                error;   ///< filtered error
    int32_t                y[2];    ///< the last reading, and the one before
    uint32_t noise;   ///< mean second difference of y, of ticks in which it changed, 0 in others, 1/256 units
    uint32_t changed; ///< share of ticks in which it did, Q32
} tribo_hold_q31_state_t;

/// Not in hold, the reference just having come to `force`; no caution.
void tribo_hold_q31_reset(tribo_hold_q31_state_t *state, int32_t force);

/// Whether the reference stands, i.e. has stayed within +-half of one place; a step of it while it stands counts as standing.
/// Cannot fail.
bool tribo_hold_q31_stands(const tribo_hold_q31_params_t *params,
                           tribo_hold_q31_state_t        *state,
                           int32_t                        reference,
                           uint32_t                       half,
                           bool                           step);

/// Begins with friction `f` fed forward at `u`, of the last tick, on the side `way`, and with the reading `y`.
void tribo_hold_q31_enter(tribo_hold_q31_state_t *state, int32_t u, int32_t f, int32_t way, int32_t y);

/// Friction to be added in this tick, from `u` of the last one and the learned breakaway. Cannot fail: what is beyond 2^29 counts
/// as the nearest that is not.
int32_t tribo_hold_q31_step(const tribo_hold_q31_params_t *params,
                            tribo_hold_q31_state_t        *state,
                            int32_t                        u,
                            uint32_t                       positive,
                            uint32_t                       negative);

/// The error less the deadband. Cannot fail: what is beyond 2^29 counts as the nearest that is not.
int32_t tribo_hold_q31_deadband(const tribo_hold_q31_params_t *params,
                                tribo_hold_q31_state_t        *state,
                                int32_t                        e,
                                int32_t                        y);

/// `travel` of slide was learned from, up to 2^20.
void tribo_hold_q31_learned(const tribo_hold_q31_params_t *params, tribo_hold_q31_state_t *state, uint32_t travel);

#ifdef __cplusplus
}
#endif

#endif
