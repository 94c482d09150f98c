/// Guard against over-compensation in fixed point: the twin of guard_f32.h, which says what it does.
///
/// Forces are Q31. Inside, r and y are taken in 2^-28 full scales and f in 2^-29, rounded towards zero, so mirrored forces give the
/// same verdict. W is 64 bits wide, in 2^-43 full scales squared: quick_ticks of full-scale turns, up to 2^17, fit.
/// One product a tick, no loops, no division. Not synchronized: one state, one tick.

#ifndef TRIBO_GUARD_Q31_H
#define TRIBO_GUARD_Q31_H

#include "tribo/guard.h"
#include "tribo/play_q31.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// What a step reads, made by tribo_guard_q31_init (quantize_q31.h).
typedef struct
{
    int32_t  half;        ///< 2^-29 full scales
    int32_t  stray;       ///< 2^-28 full scales
    int64_t  work;        ///< of hunting, 2^-43 full scales squared
    uint32_t fade;        ///< of the share in a tick, Q32
    uint32_t quick_ticks; ///< up to 2^17
} tribo_guard_q31_params_t;

typedef struct
{
    bool                   running;       ///< false before the first tick
    uint8_t                turns, strays; ///< in succession
    tribo_guard_cause_t    cause;         ///< latched
    uint32_t               share;         ///< of friction, Q32; UINT32_MAX is all of it
    uint32_t               since;         ///< ticks since the last turn, up to quick_ticks
    int64_t                work;          ///< W since then, which stands from quick_ticks on
    int32_t                high, low;     ///< largest and smallest error since then, and 0
    int32_t                r, y;          ///< of the last tick
    tribo_play_q31_state_t play;          ///< of f
} tribo_guard_q31_state_t;

/// Nothing seen, no cause, all friction.
void tribo_guard_q31_reset(tribo_guard_q31_state_t *state);

/// No cause any more; the share rises to 1 again, and what was seen is forgotten.
void tribo_guard_q31_restore(tribo_guard_q31_state_t *state);

/// Reference, reading, and the friction that is added to u in this tick, all Q31; returns the share of friction for the next one,
/// Q32. Cannot fail.
uint32_t tribo_guard_q31_step(const tribo_guard_q31_params_t *params,
                              tribo_guard_q31_state_t        *state,
                              int32_t                         r,
                              int32_t                         y,
                              int32_t                         f);

#ifdef __cplusplus
}
#endif

#endif
