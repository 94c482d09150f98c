// The loop's operations in fixed point, in addition to number/words_q31.h. loop.h, begin.h, step.h, own.h and
// hand_over.h use them.

#ifndef TRIBO_LOOP_LOOP_Q31_H
#define TRIBO_LOOP_LOOP_Q31_H

#include "tribo/force_loop_q31.h"

#include "../controller/anti_windup_q31.h"
#include "../friction/compensator_q31.h"
#include "../number/words_q31.h"

#include <stddef.h>

#include "loop.h"

#define LOOP_Q31_GAIN_FRACTION 29

typedef tribo_controller_q31_params_t loop_controller_t;
typedef tribo_biquad_q31_outputs_t    loop_nodes_t;

static inline void loop_reset_counters(loop_state_t *state)
{
    state->bad_inputs = 0;
    state->saturated  = 0;
}

/// The counter of errors and terms that do not fit.
static inline uint32_t *loop_saturated(loop_state_t *state)
{
    return &state->saturated;
}

static inline force_t loop_error(uint32_t *saturated, force_t r, force_t y)
{
    return tribo_q31_subtract(r, y, saturated);
}

/// gain f^: the term of the paper's method. Q29 x Q31, rounded down to Q31.
static inline force_t loop_term(const loop_params_t *params, force_t f, uint32_t *saturated)
{
    return tribo_q31_narrow(tribo_q31_multiply(params->gain, f), LOOP_Q31_GAIN_FRACTION, saturated);
}

/// The change of that term from friction `was` to `will`.
static inline wide_t loop_jump(const loop_params_t *params, force_t was, force_t will, fade_t fade)
{
    uint32_t     not_counted = 0;
    const wide_t after       = loop_term(params, faded_by(will, fade), &not_counted);
    return after - loop_term(params, faded_by(was, fade), &not_counted);
}

/// v, computed from the cascade's last node.
static inline force_t loop_v(const loop_controller_t *controller, force_t last)
{
    uint32_t not_counted = 0;
    return tribo_q31_widen(last, controller->cascade.output_scale, &not_counted);
}

/// The controller's output for `e`, saturated to 32 bits. No state advances.
static inline force_t loop_output(const loop_controller_t *controller, tribo_controller_q31_state_t *state, force_t e)
{
    loop_nodes_t   nodes;
    const uint32_t carry = state->cascade.carry;
    const force_t  last  = biquad_q31_output(&controller->cascade, &state->cascade, e, &nodes);
    state->cascade.carry = carry;
    return loop_v(controller, last);
}

/// v of the caller's own controller. Every int32_t is a valid value.
static inline force_t loop_credible(const uint32_t *bad_inputs, force_t v)
{
    (void)bad_inputs;
    return v;
}

/// v of the caller's own controller and the method's term. Every int32_t is a valid term.
static inline force_t loop_sum(const uint32_t *bad_inputs, force_t v, force_t term)
{
    (void)bad_inputs;
    return plus(v, term);
}

/// Writes 0 member by member: assigning a struct would call memset.
static inline void loop_rest(tribo_compensator_q31_signals_t *signals)
{
    signals->force           = 0;
    signals->friction.n      = 0;
    signals->friction.L      = 0;
    signals->friction.rise   = 0;
    signals->friction.f      = 0;
    signals->friction.relays = 0;
}

#endif
