// One tick of a cascade in Q31, in two halves as in biquad_f32_step.h: the outputs, then the states.
//
//     x, y      Q31 times 2^-scale of their node: a force may exceed full scale inside the cascade
//     b0 c1 a1  Q28, so a product with x or y is Q59
//     w1        Q59 in 64 bits          c2 d2     Q(28 + s), s = shift of the section
//     w2        Q(59 + s) in 64 bits    d2_low    Q(60 + s), the second word of d2
//
// The shift s makes room for the small w2 of a slow pole: its bits reach 2^-(59 + s) of full scale.

#ifndef TRIBO_BIQUAD_Q31_STEP_H
#define TRIBO_BIQUAD_Q31_STEP_H

#include "tribo/biquad_q31.h"

#define BIQUAD_Q31_FRACTION 28u // of the coefficients
#define BIQUAD_Q31_ONE      (INT32_C(1) << BIQUAD_Q31_FRACTION)
#define BIQUAD_Q31_HALF     (INT64_C(1) << (BIQUAD_Q31_FRACTION - 1u))
#define BIQUAD_Q31_W_MAX    ((INT64_C(1) << 61) - 1)

/// a + b c. It cannot overflow for accepted params; a corrupt state may wrap, so the sum is unsigned, which is defined.
static inline int64_t biquad_q31_accumulate(int64_t a, int32_t b, int32_t c)
{
    return (int64_t)((uint64_t)a + (uint64_t)tribo_q31_multiply(b, c));
}

/// x at the scale of the input node, rounded down. The dropped bits accumulate in `carry`; when they reach a unit it goes
/// into the sample, so the mean of the input is exact.
static inline int32_t biquad_q31_input(const tribo_biquad_q31_params_t *params, uint32_t *carry, int32_t x)
{
    const uint32_t dropped = (uint32_t)x << (31u - params->input_scale) << 1; // left-aligned; 0 at scale 0
    const uint32_t sum     = *carry + dropped;
    const uint32_t carried = sum < dropped ? 1u : 0u;
    *carry                 = sum;
    return (int32_t)((uint32_t)(x >> params->input_scale) + carried);
}

/// A section's output, y = w1 + b0 x, Q59 rounded down to Q31. The bits rounded off, `rest`, return to w1 in the second half
/// and come out with the next sample, so no bias builds up.
static inline int32_t biquad_q31_section_output(const tribo_biquad_q31_section_t *section,
                                                int64_t                           w1,
                                                int32_t                           x,
                                                uint32_t                         *rest,
                                                uint32_t                         *saturated)
{
    const int64_t sum = biquad_q31_accumulate(w1, section->b0, x);
    *rest             = (uint32_t)sum & (BIQUAD_Q31_ONE - 1u);
    return tribo_q31_narrow(sum, BIQUAD_Q31_FRACTION, saturated);
}

/// Advances a section's states for the input `in` and the output `y`, both after correction:
///
///     w1 += b0 x + c1 x - a1 y + w2 2^-s        c1 = b1 - b0
///     w2 += c2 x + d2 y                         d2 = -a2
static inline void biquad_q31_section_advance(const tribo_biquad_q31_section_t *section,
                                              tribo_biquad_q31_section_state_t *state,
                                              int32_t                           in,
                                              int32_t                           y,
                                              uint32_t                          rest,
                                              uint32_t                         *saturated)
{
    // w1 + b0 x equals y 2^28 + rest, so its place is taken by `rest` and a coefficient of y that is 1 larger, 1 - a1.
    int64_t w1 = biquad_q31_accumulate(rest, section->c1, in);
    w1         = biquad_q31_accumulate(w1, section->minus_a1 + BIQUAD_Q31_ONE, y);
    state->w1  = (int64_t)((uint64_t)w1 + (uint64_t)tribo_q31_shift(state->w2, section->shift));

    int64_t w2 = biquad_q31_accumulate(state->w2, section->c2, in);
    w2         = biquad_q31_accumulate(w2, section->d2, y);
    w2         = (int64_t)((uint64_t)w2 + (uint64_t)(tribo_q31_multiply(section->d2_low, y) >> 32));
    // Clamp at 4 2^-s of full scale. A state that started from rest stays below by its headroom; only a corrupt state or a
    // change of params gets here. w1 needs no clamp: y saturates and takes w1 with it.
    const uint32_t high = (uint32_t)((uint64_t)w2 >> 32);
    if (high + (UINT32_C(1) << 29) >= UINT32_C(1) << 30)
    {
        w2 = w2 < 0 ? -BIQUAD_Q31_W_MAX : BIQUAD_Q31_W_MAX;
        tribo_q31_count(saturated);
    }
    state->w2 = w2;
}

// Third and fourth section: the rare case. Every cascade has at least two sections (tribo_biquad_f32_init). Between the halves
// of a tick the outputs of these two are held in the state.

int32_t tribo_biquad_q31_further_output(const tribo_biquad_q31_params_t *params,
                                        tribo_biquad_q31_state_t        *state,
                                        int32_t                          x);
void    tribo_biquad_q31_further_correct(const tribo_biquad_q31_params_t *params,
                                         tribo_biquad_q31_state_t        *state,
                                         int32_t                          correction);
void    tribo_biquad_q31_further_advance(const tribo_biquad_q31_params_t *params,
                                         tribo_biquad_q31_state_t        *state,
                                         int32_t                          x);

/// First half: the nodes of the cascade for the input `x`. Returns the last node at its scale; no w advances.
static inline int32_t biquad_q31_output(const tribo_biquad_q31_params_t *params,
                                        tribo_biquad_q31_state_t        *state,
                                        int32_t                          x,
                                        tribo_biquad_q31_outputs_t      *outputs)
{
    const tribo_biquad_q31_section_t *const       s         = params->section;
    const tribo_biquad_q31_section_state_t *const w         = state->section;
    uint32_t *const                               saturated = &state->saturated;

    outputs->x    = biquad_q31_input(params, &state->carry, x);
    outputs->y[0] = biquad_q31_section_output(&s[0], w[0].w1, outputs->x, &outputs->rest[0], saturated);
    outputs->y[1] = biquad_q31_section_output(&s[1], w[1].w1, outputs->y[0], &outputs->rest[1], saturated);
    return params->count > 2u ? tribo_biquad_q31_further_output(params, state, outputs->y[1]) : outputs->y[1];
}

/// The nodes as if the input node had been larger by `correction`. Within the sample a correction reaches each output by the
/// direct feedthrough alone, times b0 of each section on the way. The controller bounds it so that it fits at each node.
static inline void biquad_q31_correct(const tribo_biquad_q31_params_t *params,
                                      tribo_biquad_q31_state_t        *state,
                                      tribo_biquad_q31_outputs_t      *outputs,
                                      int32_t                          correction)
{
    const tribo_biquad_q31_section_t *const s         = params->section;
    uint32_t *const                         saturated = &state->saturated;

    // c0 keeps 28 of its 32 bits: accurate enough at the first section. tribo-design puts slow poles, where a bias would
    // accumulate, in later sections; c1 is rounded to a unit.
    const int32_t c0 = (int32_t)((uint32_t)(tribo_q31_multiply(s[0].b0, correction) >> 32) << 4);
    const int32_t c1 = (int32_t)(tribo_q31_multiply(s[1].b0, c0) >> BIQUAD_Q31_FRACTION);
    outputs->x       = tribo_q31_add(outputs->x, correction, saturated);
    outputs->y[0]    = tribo_q31_add(outputs->y[0], c0, saturated);
    outputs->y[1]    = tribo_q31_add(outputs->y[1], c1, saturated);
    if (params->count > 2u)
    {
        tribo_biquad_q31_further_correct(params, state, c1);
    }
}

/// Second half: the states of all sections after a tick with these nodes.
static inline void biquad_q31_advance(const tribo_biquad_q31_params_t  *params,
                                      tribo_biquad_q31_state_t         *state,
                                      const tribo_biquad_q31_outputs_t *outputs)
{
    const tribo_biquad_q31_section_t *const s         = params->section;
    tribo_biquad_q31_section_state_t *const w         = state->section;
    uint32_t *const                         saturated = &state->saturated;

    biquad_q31_section_advance(&s[0], &w[0], outputs->x, outputs->y[0], outputs->rest[0], saturated);
    biquad_q31_section_advance(&s[1], &w[1], outputs->y[0], outputs->y[1], outputs->rest[1], saturated);
    if (params->count > 2u)
    {
        tribo_biquad_q31_further_advance(params, state, outputs->y[1]);
    }
}

#endif
