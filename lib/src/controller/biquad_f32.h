// Cascade of second-order sections, single precision, in the delta operator d = z - 1:
//
//              b0 d^2 + b1 d + b2         y   = b0 x + w1                first half of a tick: the outputs
//     H(d)  =  ------------------         w1 += b1 x - a1 y + w2         second half: the states
//                d^2 + a1 d + a2          w2 += b2 x - a2 y
//
// Between the halves a controller limits its output. The second half then advances the states as if the input had been
// x + correction, which is the anti-windup.
//
// The form uses d because a pole p near z = 1 is stored as 1 - p, which keeps its 24 bits however slow the pole is.
// Rounding 1 + a1 z^-1 + a2 z^-2 to float moves a pole of 0.002 rad/s at 1 kHz (0.999998) by up to 20 %; in this form
// it moves by 1e-7. The bits rounded off w2 are carried into the next sample, so slow states do not stall.
//
// A first-order section has its second pole and zero at z = 0: TRIBO_BIQUAD_F32(b0, b1, 0, a1, 0).
//
// An output beyond 1e15, far above any credible one, means a corrupt state: biquad_f32_restart puts the cascade to rest.
//
// The only loop is over the sections. Not synchronized: one state, one tick.
//
// Source: Middleton & Goodwin, "Digital Control and Estimation: A Unified Approach", ch. 13.

#ifndef TRIBO_CONTROLLER_BIQUAD_F32_H
#define TRIBO_CONTROLLER_BIQUAD_F32_H

#include "tribo/controller_f32.h"
#include "tribo/status.h"

#include "../number/ieee_f32.h"

/// The outputs of two sections, handed from the first half of a step to the second. The second half computes the
/// outputs of further sections again.
typedef struct
{
    float y[2];
} tribo_biquad_f32_outputs_t;

/// Ranges of a section's numbers, b0 to a2.
extern const tribo_parameter_t tribo_section_numbers[5];

/// Copies `count` sections, which are accepted.
void tribo_biquad_f32_fill(tribo_biquad_f32_params_t        *params,
                           const tribo_biquad_f32_section_t *sections,
                           uint32_t                          count);

/// Checks `count` sections and copies them. Returns TRIBO_OK, TRIBO_ERR_NULL, TRIBO_ERR_SECTION_COUNT or the status of
/// the first bad section, whose refused number it writes to `refusal`, unless that is null. Writes nothing else unless
/// TRIBO_OK.
tribo_status_t tribo_biquad_f32_init(tribo_biquad_f32_params_t        *params,
                                     const tribo_biquad_f32_section_t *sections,
                                     uint32_t                          count,
                                     tribo_refusal_t                  *refusal);

/// Sets all states and the counter to 0.
void tribo_biquad_f32_reset(tribo_biquad_f32_state_t *state);

/// Changes a running cascade over from params `from` to `to`, which may have another number of sections. For the input
/// `x` each section of `to` then gives the output that `from` would have given, and the same first change of it.
/// Sections missing in `to` are dropped, and new ones start at rest. The last output is then shifted so that the
/// cascade's output is unchanged, plus `offset`: what it has to make up for in a sum. A bad `x` or `offset` counts as 0.
/// Costs up to two ticks of the loop.
void tribo_biquad_f32_change(const tribo_biquad_f32_params_t *from,
                             const tribo_biquad_f32_params_t *to,
                             tribo_biquad_f32_state_t        *state,
                             float                            x,
                             float                            offset);

#define BIQUAD_F32_OUTPUT_MAX 1.0e15f // no credible gain and input exceed it, so a larger output means a corrupt state

/// A section's output, y = b0 x + w1.
static inline float biquad_f32_section_output(const tribo_biquad_f32_section_t       *section,
                                              const tribo_biquad_f32_section_state_t *state,
                                              float                                   x)
{
    return section->b0 * x + state->w1;
}

/// Advances w1 and w2 for the input `in` and the output `out`, both after correction. A slow pole adds small changes to
/// a large w2: the rounding error of each sum goes into w2_carry and is added in the next sample (Kahan's
/// compensation).
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
    state->w2_carry = change - (w2 - w2_before); // what the sum rounded off
}

// For three or four sections, the rare case, both halves are loops. Every cascade has at least two sections
// (tribo_biquad_f32_init).

float tribo_biquad_f32_long_output(const tribo_biquad_f32_params_t *params, tribo_biquad_f32_state_t *state, float x);
void  tribo_biquad_f32_long_advance(const tribo_biquad_f32_params_t *params,
                                    tribo_biquad_f32_state_t        *state,
                                    float                            x,
                                    float                            correction);

/// First half: computes the output of each section for the input `x`. Returns the last one. No state advances.
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

/// Second half: the states advance as if the input had been x + `correction`. Within the sample a correction reaches
/// each output by the direct feedthrough alone: times b0 of the first section, then times b0 of the second, and so on.
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
/// z = 1 (c2 = 0). The conditions are, in order: the polynomial at z = 1, the product of the roots, the polynomial at
/// z = -1.
static inline bool biquad_f32_is_inside_or_at_1(float c1, float c2)
{
    return c2 >= 0.0f && c2 < c1 && (4.0f - 2.0f * c1) + c2 > 0.0f;
}

#endif
