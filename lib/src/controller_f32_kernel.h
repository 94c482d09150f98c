// One tick of the controller, inline, for a caller that has checked its inputs.

#ifndef TRIBO_CONTROLLER_F32_KERNEL_H
#define TRIBO_CONTROLLER_F32_KERNEL_H

#include "tribo/controller_f32.h"

#include "biquad_f32_kernel.h"

typedef struct
{
    float u_n;
    float correction_n; ///< of the cascade's input, 0 unless limited
    bool  limited;
    bool  lost; ///< v is beyond reason
} controller_f32_limited_t;

static inline controller_f32_limited_t controller_f32_limit(const tribo_controller_f32_params_t *params,
                                                            tribo_controller_f32_state_t        *state,
                                                            float                                v,
                                                            float                                feedforward_n)
{
    const float wanted = v + feedforward_n;
    float       u      = params->u_min_n;
    if (TRIBO_USUAL(wanted >= u)) // not for a NaN
    {
        u = params->u_max_n;
        if (TRIBO_USUAL(wanted <= u))
        {
            return (controller_f32_limited_t){.u_n = wanted};
        }
    }
    count(&state->limited_ticks);
    return (controller_f32_limited_t){.u_n          = u,
                                      .correction_n = (u - wanted) * params->anti_windup,
                                      .limited      = true,
                                      .lost         = exceeds(v, BIQUAD_F32_OUTPUT_MAX)}; // which is beyond any limits
}

/// u of the tick in which the cascade's state turns out to be lost.
static inline float controller_f32_without_cascade(const tribo_controller_f32_params_t *params,
                                                   float                                feedforward_n,
                                                   tribo_controller_f32_signals_t      *signals)
{
    const float above = feedforward_n > params->u_min_n ? feedforward_n : params->u_min_n;
    const float u     = above < params->u_max_n ? above : params->u_max_n;
    *signals          = (tribo_controller_f32_signals_t){.v_n = 0.0f, .u_n = u, .limited = u != feedforward_n};
    return u;
}

/// Of a cascade of two sections, the usual case.
static inline float controller_f32_kernel(const tribo_controller_f32_params_t *params,
                                          tribo_controller_f32_state_t        *state,
                                          float                                e_n,
                                          float                                feedforward_n,
                                          tribo_controller_f32_signals_t      *signals)
{
    biquad_f32_pair_t              pair = biquad_f32_pair_output(&params->cascade, &state->cascade, e_n);
    const controller_f32_limited_t l    = controller_f32_limit(params, state, pair.y1, feedforward_n);

    // Now, so that what comes does not have to keep it.
    signals->v_n     = pair.y1;
    signals->u_n     = l.u_n;
    signals->limited = l.limited;
    if (TRIBO_RARE(l.lost))
    {
        biquad_f32_start_again(&state->cascade);
        return controller_f32_without_cascade(params, feedforward_n, signals);
    }
    if (TRIBO_RARE(l.limited))
    {
        biquad_f32_pair_correct(&params->cascade, &pair, l.correction_n);
    }
    biquad_f32_pair_advance(&params->cascade, &state->cascade, &pair);
    return l.u_n;
}

#endif
