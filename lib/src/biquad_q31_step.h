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

// Three or four sections, the rare case: both halves are loops. Every cascade has at least two sections (tribo_biquad_f32_init).

int32_t tribo_biquad_q31_long_output(const tribo_biquad_q31_params_t *params,
                                     tribo_biquad_q31_state_t        *state,
                                     int32_t                          x);
void    tribo_biquad_q31_long_advance(const tribo_biquad_q31_params_t *params,
                                      tribo_biquad_q31_state_t        *state,
                                      int32_t                          x,
                                      int32_t                          correction);

/// First half: the nodes of the cascade for the input `x`. Returns the last node at its scale; no w advances.
static inline int32_t biquad_q31_output(const tribo_biquad_q31_params_t *params,
                                        tribo_biquad_q31_state_t        *state,
                                        int32_t                          x,
                                        tribo_biquad_q31_outputs_t      *outputs)
{
    const tribo_biquad_q31_section_t *const       s         = params->section;
    const tribo_biquad_q31_section_state_t *const w         = state->section;
    uint32_t *const                               saturated = &state->saturated;

    outputs->x = biquad_q31_input(params, &state->carry, x);
    if (params->count > 2u)
    {
        *outputs = (tribo_biquad_q31_outputs_t){.x = outputs->x};
        return tribo_biquad_q31_long_output(params, state, outputs->x);
    }
    // Sections in series: the output of one is the input of the next within the same sample.
    outputs->y[0] = biquad_q31_section_output(&s[0], w[0].w1, outputs->x, &outputs->rest[0], saturated);
    outputs->y[1] = biquad_q31_section_output(&s[1], w[1].w1, outputs->y[0], &outputs->rest[1], saturated);
    return outputs->y[1];
}

/// What a `correction` of the first section's input adds to its output: within the sample it acts by the direct feedthrough
/// alone. 28 of its 32 bits are kept, accurate enough at the first section: tribo-design puts slow poles, where a bias would
/// accumulate, in later ones.
static inline int32_t biquad_q31_first_correction(const tribo_biquad_q31_section_t *section, int32_t correction)
{
    return (int32_t)((uint32_t)(tribo_q31_multiply(section->b0, correction) >> 32) << 4);
}

/// The same of a later section, rounded down to a unit.
static inline int32_t biquad_q31_later_correction(const tribo_biquad_q31_section_t *section, int32_t correction)
{
    return (int32_t)(tribo_q31_multiply(section->b0, correction) >> BIQUAD_Q31_FRACTION);
}

/// The states of two sections after a tick with these nodes.
static inline void biquad_q31_two_advance(const tribo_biquad_q31_params_t  *params,
                                          tribo_biquad_q31_state_t         *state,
                                          const tribo_biquad_q31_outputs_t *node)
{
    const tribo_biquad_q31_section_t *const s         = params->section;
    tribo_biquad_q31_section_state_t *const w         = state->section;
    uint32_t *const                         saturated = &state->saturated;

    biquad_q31_section_advance(&s[0], &w[0], node->x, node->y[0], node->rest[0], saturated);
    biquad_q31_section_advance(&s[1], &w[1], node->y[0], node->y[1], node->rest[1], saturated);
}

/// Second half: the states of all sections after a tick with these outputs, as if the input node had been larger by
/// `correction`. The controller bounds it so that it fits at each node; the sums fit, too, but after a change of params.
static inline void biquad_q31_advance(const tribo_biquad_q31_params_t  *params,
                                      tribo_biquad_q31_state_t         *state,
                                      const tribo_biquad_q31_outputs_t *outputs,
                                      int32_t                           correction)
{
    if (params->count > 2u)
    {
        tribo_biquad_q31_long_advance(params, state, outputs->x, correction);
        return;
    }
    uint32_t *const                  saturated = &state->saturated;
    const int32_t                    c0        = biquad_q31_first_correction(&params->section[0], correction);
    const int32_t                    c1        = biquad_q31_later_correction(&params->section[1], c0);
    const tribo_biquad_q31_outputs_t corrected = {
        .x    = tribo_q31_add(outputs->x, correction, saturated),
        .y    = {tribo_q31_add(outputs->y[0], c0, saturated), tribo_q31_add(outputs->y[1], c1, saturated)},
        .rest = {outputs->rest[0], outputs->rest[1]}};
    biquad_q31_two_advance(params, state, &corrected);
}

#endif
