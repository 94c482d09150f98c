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
    const int32_t            v      = (int32_t)((uint32_t)y << scale);
    controller_q31_limited_t result = {.v = v};
    int64_t                  wanted = (int64_t)v + feedforward;
    if (TRIBO_RARE(v >> scale != y))
    {
        wanted   = (int64_t)((uint64_t)((int64_t)y >> (32u - scale)) << 32 | (uint32_t)v) + feedforward;
        result.v = y < 0 ? -TRIBO_Q31_MAX : TRIBO_Q31_MAX;
    }
    result.u = (int32_t)(uint32_t)wanted;
    if (TRIBO_USUAL(result.u == wanted && result.u >= params->u_min && result.u <= params->u_max))
    {
        return result;
    }
    result.limited = true;
    result.u       = wanted < 0 ? params->u_min : params->u_max; // 0 is within them
    // u - feedforward - v at the node's scale, to its last bit or two.
    uint32_t *const saturated = &state->cascade.saturated;
    const int32_t   room      = tribo_q31_subtract(result.u >> scale, feedforward >> scale, saturated);
    const int32_t   taken     = tribo_q31_opaque(tribo_q31_subtract(room, y, saturated));
    const int64_t   back      = tribo_q31_multiply(taken, params->anti_windup);
    result.correction         = tribo_q31_narrow_by(back, params->anti_windup_shift, saturated);
    tribo_q31_count(&state->limited_ticks);
    return result;
}

/// Of a cascade of two sections, the usual case.
static inline int32_t controller_q31_kernel(const tribo_controller_q31_params_t *params,
                                            tribo_controller_q31_state_t        *state,
                                            int32_t                              e,
                                            int32_t                              feedforward,
                                            tribo_controller_q31_signals_t      *signals)
{
    int32_t                        y0;
    const uint32_t                 scale = params->cascade.section[1].scale;
    const int32_t                  x     = biquad_q31_input(&params->cascade, &state->cascade, e);
    const int32_t                  y1    = biquad_q31_pair_output(&params->cascade, &state->cascade, x, &y0);
    const controller_q31_limited_t l     = controller_q31_limit(params, state, y1, scale, feedforward);
    biquad_q31_pair_advance(&params->cascade, &state->cascade, x, y0, y1, tribo_q31_opaque(l.correction));
    *signals = (tribo_controller_q31_signals_t){.v = l.v, .u = l.u, .limited = l.limited};
    return l.u;
}

#endif
