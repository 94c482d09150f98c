// Cascade of second-order sections in Q31, in the delta operator d = z - 1. biquad_f32.h has the form and the two
// halves of a tick.
//
//     y   = w1 + b0 x                             b0: Q28, within +-4
//     w1 += b0 x + c1 x - a1 y + w2 2^-s          c1 = b1 - b0: Q28, within +-8; a1: Q28, within 4
//     w2 += c2 x + d2 y                           c2 = b2: Q(28 + s), within +-4 2^-s; d2 = -a2: Q(28 + s) and d2_low: Q(60 + s)
//
// x and y are Q31 times 2^-scale of their node, so that a force may exceed full scale inside the cascade. Both states
// have 64 bits, w1 in Q59 and w2 in Q(59 + s). The shift s makes room for the small w2 of a slow pole.
//
// y is rounded, and the bits rounded off stay in w1 and come out with the next sample. So the integral of a constant
// input does not stall, and the noise at the output is that of one rounding for any poles.
//
// A section with y beyond full scale, or w2 beyond 4 2^-s of it, restarts from rest with y = 0 and is counted. By its
// headroom only a corrupt state or a change of params leads there.
//
// d2 is the product of the poles' distances from z = 1. It has a second word, so a slow pole keeps its time constant to
// 1e-7 while a2 is above 2^-(37 + s). Of d2 y only the bits below the last of w2 (2^-59 of full scale) are dropped.
//
// The paper's controller has no zero-input limit cycles. Rounding noise has two zeros at z = 1, so a section's cycle
// stays within half an LSB of its node times the L1 norm of (1 - z^-1)^2 / A(z). That is at most 52 LSB over 130,000
// random pole pairs of radius up to 0.99 and angle up to 2.7 rad (0.43 of the sampling frequency). Poles nearer to
// z = -1, which no force controller has, reach 480 LSB (tests/unit/test_biquad_q31.c). A sharper resonance has larger
// cycles.
//
// The scale of each node comes from its worst-case peak gain (L1 norm), so no input in range can make a node overflow
// (headroom_q31.h). For accepted params all sums here stay below 2^63.
//
// The only loop is over the sections. Not synchronized: one state, one tick.

#ifndef TRIBO_CONTROLLER_BIQUAD_Q31_H
#define TRIBO_CONTROLLER_BIQUAD_Q31_H

#include "tribo/controller_q31.h"
#include "tribo/q31.h"

/// The nodes of two sections, handed from the first half of a step to the second. The second half computes the nodes of
/// further sections again from x.
typedef struct
{
    int32_t  x;       ///< the input, at the input node's scale
    int32_t  y[2];    ///< the outputs of the first two sections, each at its node's scale
    uint32_t rest[2]; ///< their rounding remainders, Q59
} tribo_biquad_q31_outputs_t;

/// Puts the cascade to rest and sets the counter to 0.
void tribo_biquad_q31_reset(tribo_biquad_q31_state_t *state);

/// Does what tribo_biquad_f32_change does, with `offset` in Q31. Not for every tick.
void tribo_biquad_q31_change(const tribo_biquad_q31_params_t *from,
                             const tribo_biquad_q31_params_t *to,
                             tribo_biquad_q31_state_t        *state,
                             int32_t                          x,
                             int32_t                          offset);

#define BIQUAD_Q31_FRACTION 28u // fraction bits of the coefficients
#define BIQUAD_Q31_ONE      (INT32_C(1) << BIQUAD_Q31_FRACTION)
#define BIQUAD_Q31_HALF     (INT64_C(1) << (BIQUAD_Q31_FRACTION - 1u))
#define BIQUAD_Q31_W_MAX    ((INT64_C(1) << 61) - 1)

/// a + b c. Accepted params cannot overflow. A corrupt state may wrap, which is defined for the unsigned sum.
static inline int64_t biquad_q31_accumulate(int64_t a, int32_t b, int32_t c)
{
    return (int64_t)((uint64_t)a + (uint64_t)tribo_q31_multiply(b, c));
}

/// x at the scale of the input node, rounded down. The dropped bits accumulate in `carry`. Each full unit of them is
/// added to the sample, so the mean of the input is exact.
static inline int32_t biquad_q31_input(const tribo_biquad_q31_params_t *params, uint32_t *carry, int32_t x)
{
    const uint32_t dropped = (uint32_t)x << (31u - params->input_scale) << 1; // left-aligned; 0 at scale 0
    const uint32_t sum     = *carry + dropped;
    const uint32_t carried = sum < dropped ? 1u : 0u;
    *carry                 = sum;
    return (int32_t)((uint32_t)(x >> params->input_scale) + carried);
}

/// Puts a section to rest and counts it. Returns its output, 0. Not inline, because it is rare.
int32_t tribo_biquad_q31_restart(tribo_biquad_q31_section_state_t *state, uint32_t *saturated);

/// A section's output, y = w1 + b0 x, Q59 rounded down to Q31. The bits rounded off, `rest`, return to w1 in the second
/// half and come out with the next sample, so no bias builds up.
static inline int32_t biquad_q31_section_output(const tribo_biquad_q31_section_t *section,
                                                tribo_biquad_q31_section_state_t *state,
                                                int32_t                           x,
                                                uint32_t                         *rest,
                                                uint32_t                         *saturated)
{
    const int64_t  sum  = biquad_q31_accumulate(state->w1, section->b0, x);
    const uint32_t high = (uint32_t)((uint64_t)sum >> 32);
    *rest               = (uint32_t)sum & (BIQUAD_Q31_ONE - 1u);
    if (high + (UINT32_C(1) << 27) >= UINT32_C(1) << 28) // beyond full scale
    {
        return tribo_biquad_q31_restart(state, saturated);
    }
    return (int32_t)(high << 4 | (uint32_t)sum >> BIQUAD_Q31_FRACTION);
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
    // w1 + b0 x equals y 2^28 + rest, so `rest` replaces it and the coefficient of y grows by 1, to 1 - a1.
    int64_t w1 = biquad_q31_accumulate(rest, section->c1, in);
    w1         = biquad_q31_accumulate(w1, section->minus_a1 + BIQUAD_Q31_ONE, y);
    state->w1  = (int64_t)((uint64_t)w1 + (uint64_t)tribo_q31_shift(state->w2, section->shift));

    int64_t w2          = biquad_q31_accumulate(state->w2, section->c2, in);
    w2                  = biquad_q31_accumulate(w2, section->d2, y);
    w2                  = (int64_t)((uint64_t)w2 + (uint64_t)(tribo_q31_multiply(section->d2_low, y) >> 32));
    const uint32_t high = (uint32_t)((uint64_t)w2 >> 32);
    state->w2           = w2;
    if (high + (UINT32_C(1) << 29) >= UINT32_C(1) << 30) // beyond 4 2^-s of full scale
    {
        (void)tribo_biquad_q31_restart(state, saturated);
    }
}

// For three or four sections, the rare case, both halves are loops. Every cascade has at least two sections
// (tribo_biquad_f32_init).

int32_t tribo_biquad_q31_long_output(const tribo_biquad_q31_params_t *params,
                                     tribo_biquad_q31_state_t        *state,
                                     int32_t                          x);
void    tribo_biquad_q31_long_advance(const tribo_biquad_q31_params_t *params,
                                      tribo_biquad_q31_state_t        *state,
                                      int32_t                          x,
                                      int32_t                          correction);

/// First half: computes the nodes of the cascade for the input `x`. Returns the last node at its scale. No w advances,
/// but a corrupt one restarts.
static inline int32_t biquad_q31_output(const tribo_biquad_q31_params_t *params,
                                        tribo_biquad_q31_state_t        *state,
                                        int32_t                          x,
                                        tribo_biquad_q31_outputs_t      *outputs)
{
    const tribo_biquad_q31_section_t *const s         = params->section;
    tribo_biquad_q31_section_state_t *const w         = state->section;
    uint32_t *const                         saturated = &state->saturated;

    outputs->x = biquad_q31_input(params, &state->carry, x);
    if (params->count > 2u)
    {
        *outputs = (tribo_biquad_q31_outputs_t){.x = outputs->x};
        return tribo_biquad_q31_long_output(params, state, outputs->x);
    }
    // Sections in series: the output of one is the input of the next within the same sample.
    outputs->y[0] = biquad_q31_section_output(&s[0], &w[0], outputs->x, &outputs->rest[0], saturated);
    outputs->y[1] = biquad_q31_section_output(&s[1], &w[1], outputs->y[0], &outputs->rest[1], saturated);
    return outputs->y[1];
}

/// The change of the first section's output by a `correction` of its input. Within the sample only the direct
/// feedthrough b0 acts. 28 of the 32 bits are enough for the first section, because tribo-design puts slow poles, where
/// a bias would accumulate, in later ones.
static inline int32_t biquad_q31_first_correction(const tribo_biquad_q31_section_t *section, int32_t correction)
{
    return (int32_t)((uint32_t)(tribo_q31_multiply(section->b0, correction) >> 32) << 4);
}

/// The change of a later section's output by a `correction` of its input, rounded down to a unit.
static inline int32_t biquad_q31_later_correction(const tribo_biquad_q31_section_t *section, int32_t correction)
{
    return (int32_t)(tribo_q31_multiply(section->b0, correction) >> BIQUAD_Q31_FRACTION);
}

/// Advances the states of two sections after a tick with these nodes.
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

/// Second half: advances the states of all sections as if the input node had been larger by `correction`. The
/// controller bounds the correction to fit at each node. The sums fit, too, except after a change of params.
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
