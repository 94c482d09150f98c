// One tick of a cascade of second-order sections in the delta operator d = z - 1 (biquad_f32.h), for a finite input:
//
//     y   = b0 x + w1                 first half: the outputs
//     w1 += b1 x - a1 y + w2          second half: the states
//     w2 += b2 x - a2 y
//
// Between the halves a controller limits its output. The second half then advances the states with a corrected input, which
// is the anti-windup.

#ifndef TRIBO_BIQUAD_F32_STEP_H
#define TRIBO_BIQUAD_F32_STEP_H

#include "tribo/biquad_f32.h"

#include "ieee_f32.h"

#define BIQUAD_F32_OUTPUT_MAX 1.0e15f // beyond any credible gain and input: the state is corrupt

/// A section's output, y = b0 x + w1.
static inline float biquad_f32_section_output(const tribo_biquad_f32_section_t       *section,
                                              const tribo_biquad_f32_section_state_t *state,
                                              float                                   x)
{
    return section->b0 * x + state->w1;
}

/// Advances w1 and w2 for the input `in` and the output `out`, both after correction. A slow pole adds small changes to a
/// large w2: what each sum rounds off goes into w2_carry and is added in the next sample (Kahan's compensation).
static inline void biquad_f32_section_advance(const tribo_biquad_f32_section_t *section,
                                              tribo_biquad_f32_section_state_t *state,
                                              float                             in,
                                              float                             out)
{
    // All three sums use the states of the present sample: w2 is read before it advances.
    const float w2_before = state->w2;
    const float change    = (section->b2 * in - section->a2 * out) + state->w2_carry;
    const float w2        = w2_before + change;

    state->w1 += (section->b1 * in - section->a1 * out) + w2_before;
    state->w2       = w2;
    state->w2_carry = change - (w2 - w2_before); // rounded off by the sum
}

// Three or four sections, the rare case: both halves are loops. Every cascade has at least two sections (tribo_biquad_f32_init).

float tribo_biquad_f32_long_output(const tribo_biquad_f32_params_t *params, tribo_biquad_f32_state_t *state, float x);
void  tribo_biquad_f32_long_advance(const tribo_biquad_f32_params_t *params,
                                    tribo_biquad_f32_state_t        *state,
                                    float                            x,
                                    float                            correction);

/// First half: the output of each section for the input `x`. Returns the last one; no state advances.
static inline float biquad_f32_output(const tribo_biquad_f32_params_t *params,
                                      tribo_biquad_f32_state_t        *state,
                                      float                            x,
                                      tribo_biquad_f32_outputs_t      *outputs)
{
    if (params->count > 2u)
    {
        *outputs = (tribo_biquad_f32_outputs_t){.y = {0.0f}};
        return tribo_biquad_f32_long_output(params, state, x);
    }
    // Sections in series: the output of one is the input of the next within the same sample.
    outputs->y[0] = biquad_f32_section_output(&params->section[0], &state->section[0], x);
    outputs->y[1] = biquad_f32_section_output(&params->section[1], &state->section[1], outputs->y[0]);
    return outputs->y[1];
}

/// Second half: the states advance as if the input had been x + `correction`. Within the sample a correction reaches each
/// output by the direct feedthrough alone: times b0 of the first section, then times b0 of the second, and so on.
static inline void biquad_f32_advance(const tribo_biquad_f32_params_t  *params,
                                      tribo_biquad_f32_state_t         *state,
                                      float                             x,
                                      const tribo_biquad_f32_outputs_t *outputs,
                                      float                             correction)
{
    if (params->count > 2u)
    {
        tribo_biquad_f32_long_advance(params, state, x, correction);
        return;
    }
    const float c0 = correction * params->section[0].b0;
    const float c1 = c0 * params->section[1].b0;
    const float y0 = outputs->y[0] + c0;
    const float y1 = outputs->y[1] + c1;
    biquad_f32_section_advance(&params->section[0], &state->section[0], x + correction, y0);
    biquad_f32_section_advance(&params->section[1], &state->section[1], y0, y1);
}

/// Puts a corrupt cascade to rest and counts it with the bad inputs.
static inline void biquad_f32_restart(tribo_biquad_f32_state_t *state)
{
    for (uint32_t i = 0; i < TRIBO_BIQUAD_SECTIONS_MAX; i++)
    {
        state->section[i] = (tribo_biquad_f32_section_state_t){0.0f, 0.0f, 0.0f};
    }
    count(&state->bad_inputs);
}

/// Jury's conditions in the delta operator: both roots of d^2 + c1 d + c2 are inside the unit circle of z, or one is at
/// z = 1 (c2 = 0). In order: the polynomial at z = 1, the product of the roots below 1, the polynomial at z = -1.
static inline bool biquad_f32_is_inside_or_at_1(float c1, float c2)
{
    return c2 >= 0.0f && c2 < c1 && (4.0f - 2.0f * c1) + c2 > 0.0f;
}

#endif
