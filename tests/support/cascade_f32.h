// A cascade of sections by itself, single precision: the two halves of a tick with nothing between them.

#ifndef TESTS_SUPPORT_CASCADE_F32_H
#define TESTS_SUPPORT_CASCADE_F32_H

#include "controller/biquad_f32.h"

static inline float cascade_f32_step(const tribo_biquad_f32_params_t *params, tribo_biquad_f32_state_t *state, float x)
{
    tribo_biquad_f32_outputs_t outputs;
    const float                y = biquad_f32_output(params, state, x, &outputs);
    biquad_f32_advance(params, state, x, &outputs, 0.0f);
    return y;
}

#endif
