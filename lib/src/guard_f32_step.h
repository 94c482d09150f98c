// The two parts of a tick of the guard, for inputs that are known to be good.

#ifndef TRIBO_GUARD_F32_STEP_H
#define TRIBO_GUARD_F32_STEP_H

#include "tribo/guard_f32.h"

#include "guard_step.h"
#include "limit_f32.h"
#include "play_f32_step.h"
#include "tribo/force_f32.h"

/// What is taken from one turn to the next.
static inline void guard_f32_begin(tribo_guard_f32_state_t *state)
{
    state->since   = 0;
    state->work_n2 = 0.0f;
    state->high_n  = 0.0f;
    state->low_n   = 0.0f;
}

/// f has turned after it went `way`, -1, 1, or 0 if it has not gone anywhere before.
static inline void guard_f32_turn(const tribo_guard_f32_params_t *params, tribo_guard_f32_state_t *state, int32_t way)
{
    if (way != 0)
    {
        // high is 0 or more, low 0 or less: the larger error less the other one, so much to the wrong side.
        const float wrong = (float)-way * (state->high_n + state->low_n);
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
    if (!state->running || exceeds(state->play.position_n, TRIBO_F32_FORCE_MAX_N)) // a corrupt play would stick
    {
        state->running = true;
        state->r_n     = r;
        state->y_n     = y;
        tribo_play_f32_reset(&state->play, f);
    }
    state->work_n2 += f * ((y - state->y_n) - 2.0f * (r - state->r_n));
    state->high_n = e > state->high_n ? e : state->high_n;
    state->low_n  = e < state->low_n ? e : state->low_n;
    state->r_n    = r;
    state->y_n    = y;
    state->since += state->since < params->quick_ticks ? 1u : 0u;

    const int32_t before = state->play.way;
    (void)play_f32_step(&state->play, f, params->half_n, params->half_n);
    if (state->play.way != before)
    {
        guard_f32_turn(params, state, before);
    }
}

static inline float guard_f32_fade(const tribo_guard_f32_params_t *params, tribo_guard_f32_state_t *state)
{
    const float by = state->cause == TRIBO_GUARD_NONE ? params->fade : -params->fade;
    state->share   = limit_f32(state->share + by, 0.0f, 1.0f);
    return state->share;
}

#endif
