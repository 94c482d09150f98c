// The loop's operations in single precision, in addition to number/words_f32.h. loop.h, begin.h, step.h, own.h and
// hand_over.h use them.

#ifndef TRIBO_LOOP_LOOP_F32_H
#define TRIBO_LOOP_LOOP_F32_H

#include "tribo/force_loop_f32.h"

#include "../controller/anti_windup_f32.h"
#include "../friction/compensator_f32.h"
#include "../number/words_f32.h"

#include <stddef.h>

#include "loop.h"

typedef tribo_controller_f32_params_t loop_controller_t;
typedef tribo_biquad_f32_outputs_t    loop_nodes_t;

static inline void loop_reset_counters(loop_state_t *state)
{
    state->bad_inputs = 0;
}

/// The counter of errors and terms that do not fit. In float all of them fit, so there is none.
static inline uint32_t *loop_saturated(loop_state_t *state)
{
    (void)state;
    return NULL;
}

static inline force_t loop_error(const uint32_t *saturated, force_t r, force_t y)
{
    (void)saturated;
    return r - y;
}

/// gain f^: the term of the paper's method.
static inline force_t loop_term(const loop_params_t *params, force_t f, const uint32_t *saturated)
{
    (void)saturated;
    return params->gain * f;
}

/// The change of that term from friction `was` to `will`.
static inline wide_t loop_jump(const loop_params_t *params, force_t was, force_t will, fade_t fade)
{
    return params->gain * (will - was) * fade;
}

/// v, computed from the cascade's last node.
static inline force_t loop_v(const loop_controller_t *controller, force_t last)
{
    (void)controller;
    return last;
}

/// The controller's output for `e`. No state advances.
static inline force_t loop_output(const loop_controller_t *controller, tribo_controller_f32_state_t *state, force_t e)
{
    loop_nodes_t nodes;
    return biquad_f32_output(&controller->cascade, &state->cascade, e, &nodes);
}

/// v of the caller's own controller. A bad value is counted and becomes 0.
static inline force_t loop_credible(uint32_t *bad_inputs, force_t v)
{
    if (!exceeds(v, TRIBO_F32_FORCE_MAX_N))
    {
        return v;
    }
    count(bad_inputs);
    return 0.0f;
}

/// v of the caller's own controller and the method's term. A term from a corrupt memory, which may be a NaN, is counted
/// and left out.
static inline force_t loop_sum(uint32_t *bad_inputs, force_t v, force_t term)
{
    if (exceeds(term, BIQUAD_F32_OUTPUT_MAX))
    {
        count(bad_inputs);
        return v;
    }
    return v + term;
}

static inline void loop_rest(tribo_compensator_f32_signals_t *signals)
{
    *signals = (tribo_compensator_f32_signals_t){.force_n = 0.0f};
}

#endif
