// One tick of the controller, for an error and a feedforward that are known to be good: cascade, output limit,
// anti-windup.

#ifndef TRIBO_CONTROLLER_F32_STEP_H
#define TRIBO_CONTROLLER_F32_STEP_H

#include "tribo/controller_f32.h"

#include "biquad_f32_step.h"

/// `wanted` at the limit that it is beyond. What is beyond none becomes 0: a NaN, or a force whose limit is one by a
/// flipped bit.
static inline float controller_f32_limit(const tribo_controller_f32_params_t *params, float wanted)
{
    if (wanted > params->u_max_n)
    {
        return params->u_max_n;
    }
    return wanted < params->u_min_n ? params->u_min_n : 0.0f;
}

/// The tick in which the cascade's state turns out to be corrupt: it starts again from rest, and u goes without it.
static inline float controller_f32_restart(const tribo_controller_f32_params_t *params,
                                           tribo_controller_f32_state_t        *state,
                                           float                                feedforward_n,
                                           tribo_controller_f32_signals_t      *signals)
{
    const bool  limited = !within(feedforward_n, params->u_min_n, params->u_max_n);
    const float u       = limited ? controller_f32_limit(params, feedforward_n) : feedforward_n;
    biquad_f32_restart(&state->cascade);
    *signals = (tribo_controller_f32_signals_t){.v_n = 0.0f, .u_n = u, .limited = limited};
    return u;
}

static inline float controller_f32_step(const tribo_controller_f32_params_t *params,
                                        tribo_controller_f32_state_t        *state,
                                        float                                e_n,
                                        float                                feedforward_n,
                                        tribo_controller_f32_signals_t      *signals)
{
    tribo_biquad_f32_outputs_t outputs;

    const float v       = biquad_f32_output(&params->cascade, &state->cascade, e_n, &outputs);
    const float wanted  = v + feedforward_n;
    const bool  limited = !within(wanted, params->u_min_n, params->u_max_n);
    float       u       = wanted;
    if (limited)
    {
        count(&state->limited_ticks);
        if (exceeds(wanted, BIQUAD_F32_OUTPUT_MAX))
        {
            return controller_f32_restart(params, state, feedforward_n, signals);
        }
        u = controller_f32_limit(params, wanted);
    }
    signals->v_n     = v; // stored early, to shorten their lives
    signals->u_n     = u;
    signals->limited = limited;

    // Anti-windup: the states see the error that would have given just u, or a part of the way there.
    biquad_f32_advance(&params->cascade, &state->cascade, e_n, &outputs, (u - wanted) * params->anti_windup);
    return u;
}

#endif
