// Guard against over-compensation, single precision: fades the friction added to u when it does harm.
//
// Its inputs are r, y and the friction f that any compensation adds to u. A play (Krasnosel'skii & Pokrovskii, "Systems with
// Hysteresis", ch. 2) separates reversals of f from noise: a position that f drags along once it is `half` away,
//
//     position = min(f + half, max(f - half, position))
//
// so that its sign changes once f has returned by 2 half. Between two reversals the guard accumulates
//
//     W = sum of f (dy - 2 dr)     work of f on the force, less twice the work that the reference requires
//     the largest error e = r - y of each sign
//
// and judges at the reversal:
//
//     hunting      the last reversal was less than quick_time_s ago, and W is over turn_n stray_n: f drives y against r.
//                  16 in succession.
//     overshoot    the largest error of the wrong sign (y beyond r in the direction of f) exceeds that of the right sign by
//                  stray_n: F broke away too early and too far. 4 in succession.
//
// An undercompensated arm breaks away late, with an error of the right sign. Its friction reverses with r, at most a few times
// more. Over the closed-loop tables of docs/compensation.md no more than 8 reversals and 2 overshoots follow one another with
// the feed-forward; a hunting loop has 10 to 30 reversals a second.
//
// The cause is latched, and the fade of friction goes from 1 to 0 within fade_time_s; tribo_guard_f32_restore undoes it as slowly.
// One product a tick, no loops. Not synchronized: one state, one tick. The functions below need good inputs.

#ifndef TRIBO_GUARD_GUARD_F32_H
#define TRIBO_GUARD_GUARD_F32_H

#include "tribo/force_loop_f32.h"
#include "tribo/status.h"

#include "../number/ieee_f32.h"
#include "guard.h"

/// All of tribo_guard_f32_init but the pointer to the step, which Q31 has no use for.
tribo_status_t tribo_guard_f32_prepare(tribo_guard_f32_params_t       *params,
                                       const tribo_guard_f32_config_t *config,
                                       float                           sample_time_s);

/// A play at `position_n`, not yet moved: sign 0.
static inline void play_f32_reset(tribo_play_f32_state_t *state, float position_n)
{
    state->position_n = position_n;
    state->sign       = 0;
}

/// One sample of the input `x`, which drags the position along from `half` away.
static inline void play_f32_step(tribo_play_f32_state_t *state, float x, float half)
{
    const float before = state->position_n;
    const float lower  = x - half;
    const float upper  = x + half;
    if (before < lower)
    {
        state->position_n = lower;
        state->sign       = 1;
    }
    else if (before > upper)
    {
        state->position_n = upper;
        state->sign       = -1;
    }
}

/// Restarts the sums between two reversals.
static inline void guard_f32_begin(tribo_guard_f32_state_t *state)
{
    state->since   = 0;
    state->work_n2 = 0.0f;
    state->high_n  = 0.0f;
    state->low_n   = 0.0f;
}

/// f has reversed after moving with `sign`, -1 or 1; 0 before its first move.
static inline void guard_f32_turn(const tribo_guard_f32_params_t *params, tribo_guard_f32_state_t *state, int32_t sign)
{
    if (sign != 0)
    {
        // high is 0 or more, low 0 or less: the largest error of the wrong sign less that of the right one.
        const float wrong = (float)-sign * (state->high_n + state->low_n);
        const bool  hunts = state->since < params->quick_ticks && state->work_n2 > params->work_n2;
        state->turns      = guard_count(state->turns, hunts, GUARD_TURNS);
        state->strays     = guard_count(state->strays, wrong > params->stray_n, GUARD_STRAYS);
        state->cause      = guard_judge(state->cause, state->turns, state->strays);
    }
    guard_f32_begin(state);
}

static inline void guard_f32_watch(const tribo_guard_f32_params_t *params,
                                   tribo_guard_f32_state_t        *state,
                                   float                           r,
                                   float                           y,
                                   float                           f)
{
    const float e = r - y;
    if (state->running == 0u || exceeds(state->play.position_n, TRIBO_F32_FORCE_MAX_N)) // a corrupt play would stick
    {
        state->running = 1;
        state->r_n     = r;
        state->y_n     = y;
        play_f32_reset(&state->play, f);
    }
    state->work_n2 += f * ((y - state->y_n) - 2.0f * (r - state->r_n));
    state->high_n = e > state->high_n ? e : state->high_n;
    state->low_n  = e < state->low_n ? e : state->low_n;
    state->r_n    = r;
    state->y_n    = y;
    state->since += state->since < params->quick_ticks ? 1u : 0u;

    const int32_t before = state->play.sign;
    play_f32_step(&state->play, f, params->half_n);
    if (state->play.sign != before)
    {
        guard_f32_turn(params, state, before);
    }
}

static inline float guard_f32_fade(const tribo_guard_f32_params_t *params, tribo_guard_f32_state_t *state)
{
    const float by = state->cause == TRIBO_GUARD_NONE ? params->fade_step : -params->fade_step;
    state->fade    = limit_f32(state->fade + by, 0.0f, 1.0f);
    return state->fade;
}

#endif
