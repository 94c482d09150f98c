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

/// Within the limits, whatever `wanted` is.
static inline float controller_f32_within(const tribo_controller_f32_params_t *params, float wanted)
{
    const float above = wanted > params->u_min_n ? wanted : params->u_min_n;
    return above < params->u_max_n ? above : params->u_max_n;
}

static inline controller_f32_limited_t controller_f32_limit(const tribo_controller_f32_params_t *params,
                                                            tribo_controller_f32_state_t        *state,
                                                            float                                v,
                                                            float                                feedforward_n)
{
    const float              wanted = v + feedforward_n;
    const float              u      = controller_f32_within(params, wanted);
    const float              taken  = u - wanted;
    controller_f32_limited_t result = {.u_n = u, .correction_n = taken * params->anti_windup};
    if (TRIBO_RARE(bits_f32(taken) != 0u)) // NaN too; no v beyond reason is within any limits
    {
        count(&state->limited_ticks);
        result.limited = true;
        result.lost    = exceeds(v, BIQUAD_F32_OUTPUT_MAX);
    }
    return result;
}

/// Of a cascade of two sections, the usual case.
static inline float controller_f32_kernel(const tribo_controller_f32_params_t *params,
                                          tribo_controller_f32_state_t        *state,
                                          float                                e_n,
                                          float                                feedforward_n,
                                          tribo_controller_f32_signals_t      *signals)
{
    float                          y0;
    const float                    v = biquad_f32_pair_output(&params->cascade, &state->cascade, e_n, &y0);
    const controller_f32_limited_t l = controller_f32_limit(params, state, v, feedforward_n);
    if (TRIBO_RARE(l.lost))
    {
        return tribo_controller_f32_start_again(params, state, feedforward_n, signals);
    }
    biquad_f32_pair_advance(&params->cascade, &state->cascade, e_n, y0, v, l.correction_n);
    *signals = (tribo_controller_f32_signals_t){.v_n = v, .u_n = l.u_n, .limited = l.limited};
    return l.u_n;
}

#endif
