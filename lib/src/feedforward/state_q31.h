// What the feed-forward with and without a force sensor share of their state, in fixed point. Not synchronized.

#ifndef TRIBO_FEEDFORWARD_STATE_Q31_H
#define TRIBO_FEEDFORWARD_STATE_Q31_H

#include "tribo/feedforward_q31.h"
#include "tribo/q31.h"

#include "bank_q31.h"

static inline const tribo_feedforward_q31_params_t *state_q31_params(const tribo_force_loop_q31_params_t *loop)
{
    return (const tribo_feedforward_q31_params_t *)loop->method;
}

static inline bool state_q31_runs(const tribo_feedforward_q31_state_t *state)
{
    return state->mode >= TRIBO_FEEDFORWARD_START && state->mode <= TRIBO_FEEDFORWARD_HOLD;
}

static inline bool state_q31_stays(const tribo_feedforward_q31_state_t *state)
{
    return state->mode == TRIBO_FEEDFORWARD_HOLD && state->hold.rests;
}

static inline void state_q31_rest(tribo_feedforward_q31_state_t *state, int32_t r, int32_t at)
{
    const bool enters = state->mode == TRIBO_FEEDFORWARD_ENTER;

    state->mode        = TRIBO_FEEDFORWARD_START;
    state->offset_rule = enters ? TRIBO_FEEDFORWARD_TAKE_OVER : TRIBO_FEEDFORWARD_KEEP;
    state->offset      = 0;
    state->sign        = 0;
    state->limited     = 0;
    state->r[0]        = r;
    state->r[1]        = r;
    state->noise       = 0;
    state->reached     = at;
    state->rate        = 0;
    state->settled     = at;
    state->turned      = at;
    state->sigma       = 0;
    state->behind[0]   = 0;
    state->behind[1]   = 0;
    state->f           = 0;
    state->v           = 0;
}

static inline void state_q31_forget(tribo_feedforward_q31_state_t *state)
{
    const int32_t  term      = state->tick.term;
    const uint32_t forgotten = state->forgotten;
    tribo_feedforward_q31_reset(state);
    state->mode      = TRIBO_FEEDFORWARD_ENTER;
    state->tick.term = term;
    state->forgotten = forgotten;
    tribo_q31_count(&state->forgotten);
}

/// As the twin's.
static inline void state_q31_note_bound(tribo_feedforward_q31_state_t *state)
{
    const int32_t  V     = state->learned.weight[0];
    const bool     bound = V <= BANK_Q31_Q29(FEEDFORWARD_WEIGHT_LOW) || V >= BANK_Q31_Q29(FEEDFORWARD_WEIGHT_MAX);
    const uint32_t turns = bound ? state->at_bound + 1u : 0u;
    state->at_bound      = tribo_feedforward_stays_at_bound(state->at_bound) ? state->at_bound : (uint8_t)turns;
}

/// As the twin's.
static inline void state_q31_enter(tribo_feedforward_q31_state_t *state, int32_t term, bool anew)
{
    if (state->mode == TRIBO_FEEDFORWARD_RESTART && !anew)
    {
        return; // still at rest
    }
    const bool goes_on = state_q31_runs(state) && !anew;
    state->mode        = goes_on ? state->mode : TRIBO_FEEDFORWARD_ENTER;
    state->offset_rule = goes_on ? TRIBO_FEEDFORWARD_TAKE_OVER : TRIBO_FEEDFORWARD_KEEP;
    state->tick.term   = term;
    state->tick.has_e  = goes_on;
}

/// `u` is Q31.
static inline void state_q31_show(tribo_force_loop_q31_signals_t *signals, int32_t u, int32_t F, int32_t L, int32_t f)
{
    uint32_t ignored = 0;

    signals->compensator.force      = bank_q31_outside(F);
    signals->compensator.friction.n = tribo_q31_subtract(u, signals->compensator.force, &ignored);
    signals->compensator.friction.L = bank_q31_outside(L);
    signals->compensator.friction.f = bank_q31_outside(f);
}

#endif
