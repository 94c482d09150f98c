// A cascade of sections, and a controller, by itself, single precision: the two halves of a tick.

#ifndef TESTS_SUPPORT_CASCADE_F32_H
#define TESTS_SUPPORT_CASCADE_F32_H

#include "controller/anti_windup_f32.h"
#include "controller/biquad_f32.h"

static inline float cascade_f32_step(const tribo_biquad_f32_params_t *params, tribo_biquad_f32_state_t *state, float x)
{
    tribo_biquad_f32_outputs_t outputs;
    const float                y = biquad_f32_output(params, state, x, &outputs);
    biquad_f32_advance(params, state, x, &outputs, 0.0f);
    return y;
}

/// A controller by itself: u for the error `e_n`.
static inline float controller_f32_step(const tribo_controller_f32_params_t *params,
                                        tribo_controller_f32_state_t        *state,
                                        float                                e_n,
                                        float                                term_n,
                                        tribo_controller_f32_signals_t      *signals)
{
    tribo_biquad_f32_outputs_t outputs;

    const float v = biquad_f32_output(&params->cascade, &state->cascade, e_n, &outputs);
    return controller_f32_apply(params, state, e_n, v, term_n, &outputs, signals);
}

#endif
