// When friction is fed back, for both arithmetics: the monitor of docs/feedforward.md. Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_FEEDBACK_H
#define TRIBO_FEEDFORWARD_FEEDBACK_H

#include "tribo/feedforward_f32.h"

#include "constants.h"

static inline bool feedback_is_on(const tribo_feedforward_feedback_t *x)
{
    return x->harms != 0u && x->left > 0u;
}

/// At a reversal fed back. True at the last: friction is then fed forward on trial.
static inline bool feedback_ends(tribo_feedforward_feedback_t *x)
{
    x->left--;
    return x->left == 0u;
}

/// At a reversal fed forward. One that does harm ends in feedback, longer the less it was fed forward since the last.
static inline void feedback_judge(tribo_feedforward_feedback_t *x, bool harms)
{
    const uint32_t rest = x->length > 0u ? x->length - 1u : 0u;
    const uint32_t next = FEEDFORWARD_FEEDBACK_GROWTH * rest;
    const uint32_t most = next < FEEDFORWARD_FEEDBACK_MAX ? next : FEEDFORWARD_FEEDBACK_MAX;
    x->length           = (uint8_t)rest;
    if (harms)
    {
        x->harms  = true;
        x->length = (uint8_t)(most > FEEDFORWARD_FEEDBACK_MIN ? most : FEEDFORWARD_FEEDBACK_MIN);
        x->left   = x->length;
    }
}

/// Takes back what the monitor has found.
static inline void feedback_restore(tribo_feedforward_feedback_t *x)
{
    x->harms  = false;
    x->left   = 0;
    x->length = 0;
}

#endif
