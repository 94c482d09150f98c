// One tick of the controller: cascade, output limit, anti-windup.

#ifndef TRIBO_CONTROLLER_Q31_STEP_H
#define TRIBO_CONTROLLER_Q31_STEP_H

#include "tribo/controller_q31.h"

#include "biquad_q31_step.h"

/// What the error is to be corrected by, at the input node, for what the limit has taken off v + feedforward. Both `u` and
/// `wanted` are at the scale of the last node.
static inline int32_t controller_q31_correction(const tribo_controller_q31_params_t *params,
                                                int32_t                              u,
                                                int32_t                              wanted,
                                                uint32_t                            *saturated)
{
    const uint32_t most  = (uint32_t)params->taken_max;
    int32_t        taken = (int32_t)((uint32_t)u - (uint32_t)wanted);
    if ((uint32_t)taken + most > 2u * most) // |taken| > most: after a change of params, or 2^31, which wraps
    {
        tribo_q31_count(saturated);
        taken = wanted < 0 ? params->taken_max : -params->taken_max;
    }
    const int32_t back = (int32_t)(tribo_q31_multiply(taken, params->anti_windup) >> 32);
    return (int32_t)((uint32_t)back << params->anti_windup_shift); // fits, see taken_max
}

static inline int32_t controller_q31_step(const tribo_controller_q31_params_t *params,
                                          tribo_controller_q31_state_t        *state,
                                          int32_t                              e,
                                          int32_t                              feedforward,
                                          tribo_controller_q31_signals_t      *signals)
{
    tribo_biquad_q31_outputs_t outputs;
    uint32_t                   not_counted = 0;
    uint32_t *const            saturated   = &state->cascade.saturated;

    const int32_t  y      = biquad_q31_output(&params->cascade, &state->cascade, e, &outputs);
    const uint32_t scale  = params->cascade.output_scale;
    const int64_t  wanted = tribo_q31_lift(y, scale) + feedforward; // v + feedforward

    int32_t    u          = (int32_t)wanted;
    int32_t    correction = 0;
    const bool limited    = u != wanted || u < params->u_min || u > params->u_max;
    if (limited)
    {
        u = wanted < 0 ? params->u_min : params->u_max; // 0 is within the limits
        correction =
            controller_q31_correction(params, u >> scale, tribo_q31_add(y, feedforward >> scale, saturated), saturated);
        tribo_q31_count(&state->limited_ticks);
    }
    signals->v       = tribo_q31_widen(y, scale, &not_counted); // stored early, to shorten their lives
    signals->u       = u;
    signals->limited = limited;

    // Anti-windup: the states see the error that would have given just u, or a part of the way there.
    biquad_q31_correct(&params->cascade, &state->cascade, &outputs, correction);
    biquad_q31_advance(&params->cascade, &state->cascade, &outputs);
    return u;
}

#endif
