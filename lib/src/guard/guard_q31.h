// Guard against over-compensation in fixed point: the twin of guard_f32.h.
//
// Forces are Q31. Inside, r and y are taken in 2^-28 full scales and f in 2^-29, rounded towards zero, so mirrored forces give the
// same verdict. W is 64 bits wide, in 2^-43 full scales squared: quick_ticks of full-scale turns, up to 2^17, fit.
// One product a tick, no loops, no division. Not synchronized: one state, one tick.

#ifndef TRIBO_GUARD_GUARD_Q31_H
#define TRIBO_GUARD_GUARD_Q31_H

#include "tribo/force_loop_f32.h"
#include "tribo/force_loop_q31.h"
#include "tribo/q31.h"

#include "../number/first_order_q31.h"
#include "guard.h"

/// What lies beyond the scale, or is no number, is put there.
static inline bool guard_q31_is_end(int32_t x)
{
    return tribo_q31_magnitude(x) >= (uint32_t)TRIBO_Q31_MAX;
}

#define PLAY_Q31_MAX (INT32_C(1) << 30) // of its values, so that x - half and x + half fit

/// A corrupt position counts as the nearest end of the range.
static inline void play_q31_reset(tribo_play_q31_state_t *state, int32_t position)
{
    state->position = limit_q31(position, -PLAY_Q31_MAX, PLAY_Q31_MAX);
    state->sign     = 0;
}

static inline void play_q31_step(tribo_play_q31_state_t *state, int32_t x, int32_t half)
{
    const int32_t before = state->position;
    const int32_t lower  = x - half;
    const int32_t upper  = x + half;
    if (before < lower)
    {
        state->position = lower;
        state->sign     = 1;
    }
    else if (before > upper)
    {
        state->position = upper;
        state->sign     = -1;
    }
}

/// Restarts the sums between two reversals.
static inline void guard_q31_begin(tribo_guard_q31_state_t *state)
{
    state->since = 0;
    state->work  = 0;
    state->high  = 0;
    state->low   = 0;
}

/// f has reversed after moving with `sign`, -1 or 1; 0 before its first move.
static inline void guard_q31_turn(const tribo_guard_q31_params_t *params, tribo_guard_q31_state_t *state, int32_t sign)
{
    if (sign != 0)
    {
        // high is 0 or more, low 0 or less: the largest error of the wrong sign less that of the right one.
        const int64_t wrong = -sign * ((int64_t)state->high + state->low);
        const bool    hunts = state->since < params->quick_ticks && state->work > params->work;
        state->turns        = guard_count(state->turns, hunts, GUARD_TURNS);
        state->strays       = guard_count(state->strays, wrong > params->stray, GUARD_STRAYS);
        state->cause        = guard_judge(state->cause, state->turns, state->strays);
    }
    guard_q31_begin(state);
}

static inline void guard_q31_watch(const tribo_guard_q31_params_t *params,
                                   tribo_guard_q31_state_t        *state,
                                   int32_t                         r_q31,
                                   int32_t                         y_q31,
                                   int32_t                         f_q31)
{
    // |r| and |y| up to 2^28, |f| up to 2^29
    const int32_t r = r_q31 / 8;
    const int32_t y = y_q31 / 8;
    const int32_t f = f_q31 / 4;
    const int32_t e = r - y;
    if (state->running == 0u)
    {
        state->running = 1;
        state->r       = r;
        state->y       = y;
        play_q31_reset(&state->play, f);
    }
    // |moved| up to 3 2^29, so W goes by up to 3 2^44 in each of up to 2^17 ticks
    const int32_t moved = (int32_t)((uint32_t)(y - 2 * r) - ((uint32_t)state->y - 2u * (uint32_t)state->r));
    if (state->since < params->quick_ticks)
    {
        state->work = (int64_t)((uint64_t)state->work + (uint64_t)tribo_q31_shift(tribo_q31_multiply(f, moved), 14));
        state->since++;
    }
    state->high = e > state->high ? e : state->high;
    state->low  = e < state->low ? e : state->low;
    state->r    = r;
    state->y    = y;

    const int32_t before = state->play.sign;
    play_q31_step(&state->play, f, params->half);
    if (state->play.sign != before)
    {
        guard_q31_turn(params, state, before);
    }
}

static inline uint32_t guard_q31_fade(const tribo_guard_q31_params_t *params, tribo_guard_q31_state_t *state)
{
    const uint32_t fade = state->fade;
    const uint32_t room = state->cause == TRIBO_GUARD_NONE ? ~fade : fade;
    const uint32_t by   = params->fade_step < room ? params->fade_step : room;
    state->fade         = state->cause == TRIBO_GUARD_NONE ? fade + by : fade - by;
    return state->fade;
}

#endif
