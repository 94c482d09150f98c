// The guard's operations in fixed point, in addition to number/words_q31.h. guard.h and guard_step.h use them.
//
// Forces are Q31. The guard converts r and y to units of 2^-28 full scales and f to 2^-29, rounded towards zero, so
// mirrored forces give the same verdict. W has 64 bits, in units of 2^-43 full scales squared: up to 2^17 quick_ticks
// of full-scale moves fit.

#ifndef TRIBO_LOOP_GUARD_Q31_H
#define TRIBO_LOOP_GUARD_Q31_H

#include "tribo/force_loop_q31.h"

#include "../number/words_q31.h"

#include <stddef.h>

#define PLAY_MAX (INT32_C(1) << 30) // so that x - half and x + half fit

/// r or y in the guard's units, up to 2^28.
static inline force_t guard_signal(force_t x)
{
    return x / 8;
}

/// f in the guard's units, up to 2^29.
static inline force_t guard_friction(force_t f)
{
    return f / 4;
}

/// False if r or y is at a limit of the scale, which stands for an input beyond the scale or no number at all. Taken as
/// unsigned, these limits are three consecutive numbers: 2^31 - 1, -2^31, -(2^31 - 1).
static inline bool guard_is_credible(force_t r, force_t y, force_t f)
{
    (void)f;
    return (uint32_t)r - (uint32_t)TRIBO_Q31_MAX > 2u && (uint32_t)y - (uint32_t)TRIBO_Q31_MAX > 2u;
}

/// No integer can make the play stick: it recovers by itself.
static inline bool guard_is_corrupt(const tribo_guard_q31_state_t *state)
{
    (void)state;
    return false;
}

/// W with the work of this tick. |moved| is at most 3 2^29, so W changes by at most 3 2^44 in each of up to 2^17 ticks.
static inline wide_t guard_work(const tribo_guard_q31_state_t *state, force_t r, force_t y, force_t f)
{
    const int32_t moved = (int32_t)((uint32_t)(y - 2 * r) - ((uint32_t)state->y - 2u * (uint32_t)state->r));
    return (int64_t)((uint64_t)state->work + (uint64_t)tribo_q31_shift(tribo_q31_multiply(f, moved), 14));
}

#include "guard.h"

#endif
