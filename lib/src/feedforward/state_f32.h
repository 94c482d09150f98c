// What the feed-forward with and without a force sensor share of their state, single precision. Not synchronized.

#ifndef TRIBO_FEEDFORWARD_STATE_F32_H
#define TRIBO_FEEDFORWARD_STATE_F32_H

#include "tribo/feedforward_f32.h"

#include "../number/ieee_f32.h"
#include "constants.h"

/// The params of which `loop->method` is the first member.
static inline const tribo_feedforward_f32_params_t *state_f32_params(const tribo_force_loop_f32_params_t *loop)
{
    return (const tribo_feedforward_f32_params_t *)loop->method;
}

static inline bool state_f32_runs(const tribo_feedforward_f32_state_t *state)
{
    return state->mode >= TRIBO_FEEDFORWARD_START && state->mode <= TRIBO_FEEDFORWARD_HOLD;
}

/// True if u stays, as the error of a hold is within the noise.
static inline bool state_f32_stays(const tribo_feedforward_f32_state_t *state)
{
    return state->mode == TRIBO_FEEDFORWARD_HOLD && state->hold.rests;
}

/// At rest at force `at` with reference r. Beside a running controller b takes over so that u goes on.
static inline void state_f32_rest(tribo_feedforward_f32_state_t *state, float r, float at)
{
    const bool enters = state->mode == TRIBO_FEEDFORWARD_ENTER;

    state->mode        = TRIBO_FEEDFORWARD_START;
    state->offset_rule = enters ? TRIBO_FEEDFORWARD_TAKE_OVER : TRIBO_FEEDFORWARD_KEEP;
    state->offset_n    = 0.0f;
    state->sign        = 0;
    state->limited     = 0;
    state->r_n[0]      = r;
    state->r_n[1]      = r;
    state->noise_n     = 0.0f;
    state->reached_n   = at;
    state->rate_n_s    = 0.0f;
    state->settled_n   = at;
    state->turned_n    = at;
    state->sigma       = 0.0f;
    state->behind_n[0] = 0.0f;
    state->behind_n[1] = 0.0f;
    state->f_n         = 0.0f;
    state->v_n         = 0.0f;
}

/// A corrupt memory: everything is forgotten, and u goes on.
static inline void state_f32_forget(const tribo_feedforward_f32_params_t *params, tribo_feedforward_f32_state_t *state)
{
    const float    term      = state->tick.term_n;
    const uint32_t forgotten = state->forgotten;
    tribo_feedforward_f32_reset(state);
    state->mode        = TRIBO_FEEDFORWARD_ENTER;
    state->tick.term_n = exceeds(term, params->offset_max_n) ? 0.0f : term;
    state->forgotten   = forgotten;
    count(&state->forgotten);
}

/// Counts the reversals in succession that find V_0 at a bound; 4 stays.
static inline void state_f32_note_bound(tribo_feedforward_f32_state_t *state)
{
    const float    V     = state->learned.weight[0];
    const bool     bound = !(V > FEEDFORWARD_WEIGHT_LOW && V < FEEDFORWARD_WEIGHT_MAX);
    const uint32_t turns = bound ? state->at_bound + 1u : 0u;
    state->at_bound      = tribo_feedforward_stays_at_bound(state->at_bound) ? state->at_bound : (uint8_t)turns;
}

/// Before a tick with other params or beside another controller: the tick shall add `term`. `anew`: another method ran before.
static inline void state_f32_enter(tribo_feedforward_f32_state_t *state, float term, bool anew)
{
    if (state->mode == TRIBO_FEEDFORWARD_RESTART && !anew)
    {
        return; // still at rest
    }
    const bool goes_on = state_f32_runs(state) && !anew;
    state->mode        = goes_on ? state->mode : TRIBO_FEEDFORWARD_ENTER;
    state->offset_rule = goes_on ? TRIBO_FEEDFORWARD_TAKE_OVER : TRIBO_FEEDFORWARD_KEEP;
    state->tick.term_n = exceeds(term, TRIBO_F32_FORCE_MAX_N) ? 0.0f : term;
    state->tick.has_e  = goes_on;
}

/// The force F, breakaway L and friction f of a tick that put out u. Member by member: a struct would be cleared by a call.
static inline void state_f32_show(tribo_force_loop_f32_signals_t *signals, float u, float F, float L, float f)
{
    signals->compensator.force_n      = F;
    signals->compensator.friction.n_n = u - F;
    signals->compensator.friction.L_n = L;
    signals->compensator.friction.f_n = f;
}

#endif
