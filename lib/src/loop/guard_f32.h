// The guard's operations in single precision, in addition to number/words_f32.h. guard.h and guard_step.h use them.

#ifndef TRIBO_LOOP_GUARD_F32_H
#define TRIBO_LOOP_GUARD_F32_H

#include "tribo/force_loop_f32.h"

#include "../number/words_f32.h"

#include <stddef.h>

#define PLAY_MAX TRIBO_F32_FORCE_MAX_N

/// Float needs no conversion of forces.
static inline force_t guard_signal(force_t x)
{
    return x;
}

static inline force_t guard_friction(force_t f)
{
    return f;
}

static inline bool guard_is_credible(force_t r, force_t y, force_t f)
{
    return !exceeds(r, TRIBO_F32_FORCE_MAX_N) && !exceeds(y, TRIBO_F32_FORCE_MAX_N) &&
           !exceeds(f, TRIBO_F32_FORCE_MAX_N);
}

/// True if the play is corrupt, e.g. a NaN, which no input could move again.
static inline bool guard_is_corrupt(const tribo_guard_f32_state_t *state)
{
    return exceeds(state->play.position_n, TRIBO_F32_FORCE_MAX_N);
}

/// W with the work of this tick.
static inline wide_t guard_work(const tribo_guard_f32_state_t *state, force_t r, force_t y, force_t f)
{
    return state->work + f * ((y - state->y_n) - 2.0f * (r - state->r_n));
}

#include "guard.h"

#endif
