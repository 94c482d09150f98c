// One tick of the controller, inline.

#ifndef TRIBO_CONTROLLER_Q31_KERNEL_H
#define TRIBO_CONTROLLER_Q31_KERNEL_H

#include "tribo/controller_q31.h"

#include "biquad_q31_kernel.h"
#include "usual.h"

typedef struct
{
    int32_t u;
    int32_t v;          ///< saturated, for the log
    int32_t correction; ///< of the cascade's input, at its scale; 0 unless limited
    bool    limited;
} controller_q31_limited_t;

/// `y` is the cascade's output at its node's `scale`.
static inline controller_q31_limited_t controller_q31_limit(const tribo_controller_q31_params_t *params,
                                                            tribo_controller_q31_state_t        *state,
                                                            int32_t                              y,
                                                            uint32_t                             scale,
                                                            int32_t                              feedforward)
{
    // v + feedforward: its low word, and its floor at the node's scale, which agree where it fits.
    uint32_t *const saturated   = &state->cascade.saturated;
    const int32_t   v           = (int32_t)((uint32_t)y << scale);
    const int32_t   sum         = (int32_t)((uint32_t)v + (uint32_t)feedforward);
    const int32_t   wanted      = tribo_q31_add(y, feedforward >> scale, saturated);
    uint32_t        not_counted = 0;
    int32_t         u           = sum;
    int32_t         taken       = 0;
    const bool      limited     = sum >> scale != wanted || sum < params->u_min || sum > params->u_max;
    if (TRIBO_RARE(limited))
    {
        tribo_q31_count(&state->limited_ticks);
        u                   = wanted < 0 ? params->u_min : params->u_max; // 0 is within them
        const uint32_t most = (uint32_t)params->taken_max;
        taken               = (int32_t)((uint32_t)(u >> scale) - (uint32_t)wanted);
        if ((uint32_t)taken + most > 2u * most) // after a change of params
        {
            tribo_q31_count(saturated);
            taken = wanted < 0 ? params->taken_max : -params->taken_max;
        }
    }
    const int64_t back = tribo_q31_multiply(tribo_q31_opaque(taken), params->anti_windup);
    return (controller_q31_limited_t){
        .u = u,
        .v = limited ? tribo_q31_widen(y, scale, &not_counted) : tribo_q31_subtract(sum, feedforward, &not_counted),
        .correction = (int32_t)((uint32_t)(back >> 32) << params->anti_windup_shift), // fits, see taken_max
        .limited    = limited};
}

/// Of a pair of sections.
static inline int32_t controller_q31_kernel(const tribo_controller_q31_params_t *params,
                                            tribo_controller_q31_state_t        *state,
                                            int32_t                              e,
                                            int32_t                              feedforward,
                                            tribo_controller_q31_signals_t      *signals)
{
    biquad_q31_pair_t              pair  = biquad_q31_pair_output(&params->cascade, &state->cascade, e);
    const uint32_t                 scale = params->cascade.section[1].scale;
    const controller_q31_limited_t l     = controller_q31_limit(params, state, pair.out[1].y, scale, feedforward);

    // u on the stack: gcc would put aside what costs more.
    const volatile int32_t u = l.u;
    // By 0 in most ticks: one that limits shall not take longer.
    biquad_q31_pair_correct(&params->cascade, &state->cascade, &pair, l.correction);
    // Now, so that what comes does not have to keep it.
    *signals = (tribo_controller_q31_signals_t){.v = l.v, .u = l.u, .limited = l.limited};
    // Factors that are either a sum or its bound: see tribo_q31_opaque.
    pair.x        = tribo_q31_opaque(pair.x);
    pair.out[0].y = tribo_q31_opaque(pair.out[0].y);
    pair.out[1].y = tribo_q31_opaque(pair.out[1].y);
    biquad_q31_pair_advance(&params->cascade, &state->cascade, &pair);
    return u;
}

#endif
