// One tick of the controller, inline, for a caller that has checked its inputs.

#ifndef TRIBO_CONTROLLER_F32_KERNEL_H
#define TRIBO_CONTROLLER_F32_KERNEL_H

#include "tribo/controller_f32.h"

#include "biquad_f32_kernel.h"

/// The tick in which the cascade's state turns out to be lost.
float tribo_controller_f32_start_again(const tribo_controller_f32_params_t *params,
                                       tribo_controller_f32_state_t        *state,
                                       float                                feedforward_n,
                                       tribo_controller_f32_signals_t      *signals);

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
    if (TRIBO_USUAL(wanted >= params->u_min_n && wanted <= params->u_max_n))
    {
        return (controller_f32_limited_t){.u_n = wanted};
    }
    // NaN too, for which u is u_min; no v beyond reason is within any limits.
    const float u = wanted > params->u_max_n ? params->u_max_n : params->u_min_n;
    count(&state->limited_ticks);
    return (controller_f32_limited_t){.u_n          = u,
                                      .correction_n = (u - wanted) * params->anti_windup,
                                      .limited      = true,
                                      .lost         = exceeds(v, BIQUAD_F32_OUTPUT_MAX)};
}

/// Of a cascade of two sections, the usual case.
static inline float controller_f32_kernel(const tribo_controller_f32_params_t *params,
                                          tribo_controller_f32_state_t        *state,
                                          float                                e_n,
                                          float                                feedforward_n,
                                          tribo_controller_f32_signals_t      *signals)
{
    biquad_f32_pair_t              pair = biquad_f32_pair_output(&params->cascade, &state->cascade, e_n);
    const float                    v    = pair.y1;
    const controller_f32_limited_t l    = controller_f32_limit(params, state, v, feedforward_n);
    if (TRIBO_RARE(l.lost))
    {
        return tribo_controller_f32_start_again(params, state, feedforward_n, signals);
    }
    if (TRIBO_RARE(l.limited))
    {
        biquad_f32_pair_correct(&params->cascade, &pair, l.correction_n);
    }
    biquad_f32_pair_advance(&params->cascade, &state->cascade, &pair);
    *signals = (tribo_controller_f32_signals_t){.v_n = v, .u_n = l.u_n, .limited = l.limited};
    return l.u_n;
}

#endif
