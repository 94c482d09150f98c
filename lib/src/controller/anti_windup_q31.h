// One tick of the controller in Q31: v = K(z) e, u = limit(v + term), and the anti-windup of anti_windup_f32.h.
//
//     y, unsaturated, taken   at the scale of the last node      correction   at the scale of the input node
//     v, u, term              Q31
//
// A node of the cascade holds its value times 2^-scale, so v = y 2^output_scale may exceed full scale. The sum v + term
// is therefore held at the scale of the last node, rounded down to fit 32 bits, as `unsaturated`.

#ifndef TRIBO_CONTROLLER_ANTI_WINDUP_Q31_H
#define TRIBO_CONTROLLER_ANTI_WINDUP_Q31_H

#include "tribo/controller_q31.h"

#include "biquad_q31.h"

/// Puts the cascade to rest and sets the counters to 0.
void tribo_controller_q31_reset(tribo_controller_q31_state_t *state);

/// (u - unsaturated) c/D, the correction of the error at the input node. It is 0 while u is not limited. `u` and
/// `unsaturated` are at the scale of the last node. anti_windup is c/D as a mantissa of 31 bits, with the exponent
/// anti_windup_shift - 32.
static inline int32_t controller_q31_correction(const tribo_controller_q31_params_t *params,
                                                int32_t                              u,
                                                int32_t                              unsaturated,
                                                uint32_t                            *saturated)
{
    const uint32_t most  = (uint32_t)params->taken_max;
    int32_t        taken = (int32_t)((uint32_t)u - (uint32_t)unsaturated);
    // Tests |taken| > most in one comparison. That happens after a change of params, or if the difference wraps.
    if ((uint32_t)taken + most > 2u * most)
    {
        tribo_q31_count(saturated);
        taken = unsaturated < 0 ? params->taken_max : -params->taken_max;
    }
    const int32_t back = (int32_t)(tribo_q31_multiply(taken, params->anti_windup) >> 32);
    return (int32_t)((uint32_t)back << params->anti_windup_shift); // fits because |taken| <= taken_max
}

/// Second half of a tick: computes u for the cascade's last node `y` and advances its states. u is within u_min to
/// u_max in any state.
static inline int32_t controller_q31_apply(const tribo_controller_q31_params_t *params,
                                           tribo_controller_q31_state_t        *state,
                                           int32_t                              e,
                                           int32_t                              y,
                                           int32_t                              term,
                                           const tribo_biquad_q31_outputs_t    *outputs,
                                           tribo_controller_q31_signals_t      *signals)
{
    uint32_t        not_counted = 0;
    uint32_t *const saturated   = &state->cascade.saturated;
    (void)e; // `outputs` hold it

    const uint32_t scale       = params->cascade.output_scale;
    const int32_t  unsaturated = tribo_q31_add(y, term >> scale, saturated);

    // v + term in Q31. If the sum does not fit it wraps, and then differs from `unsaturated` at the scale of the last
    // node.
    int32_t    u       = (int32_t)(((uint32_t)y << scale) + (uint32_t)term);
    const bool limited = u >> scale != unsaturated || u < params->u_min || u > params->u_max;
    if (limited)
    {
        u = unsaturated < 0 ? params->u_min : params->u_max; // u_min <= 0 <= u_max
        tribo_q31_count(&state->limited_ticks);
    }
    signals->v       = tribo_q31_widen(y, scale, &not_counted);
    signals->u       = u;
    signals->limited = limited;

    // Anti-windup: the states advance as if the error had been larger by the correction.
    const int32_t correction = controller_q31_correction(params, u >> scale, unsaturated, saturated);
    biquad_q31_advance(&params->cascade, &state->cascade, outputs, correction);
    return u;
}

#endif
