// What a tick of a cascade is made of, inline.

#ifndef TRIBO_BIQUAD_Q31_KERNEL_H
#define TRIBO_BIQUAD_Q31_KERNEL_H

#include "tribo/biquad_q31.h"

#define BIQUAD_Q31_FRACTION 28u
#define BIQUAD_Q31_HALF     (INT64_C(1) << (BIQUAD_Q31_FRACTION - 1u))
#define BIQUAD_Q31_W_MAX    ((INT64_C(1) << 61) - 1)

/// Clamps the states to +-W_MAX and counts. Only a state that was never reached from rest can need it.
void tribo_biquad_q31_clamp(tribo_biquad_q31_state_t *state);

/// Below 2^30 while w is within +-W_MAX: or-ed together, one compare serves all states.
static inline uint32_t biquad_q31_excess(int64_t w)
{
    return (uint32_t)((uint64_t)w >> 32) + (UINT32_C(1) << 29);
}

static inline int32_t biquad_q31_section_output(const tribo_biquad_q31_section_t *section,
                                                int64_t                           w1,
                                                int32_t                           x,
                                                uint32_t                         *saturated)
{
    // Unsigned, as a lost state may wrap.
    const uint64_t sum = (uint64_t)w1 + (uint64_t)tribo_q31_multiply(section->b0, x);
    return tribo_q31_narrow((int64_t)sum, BIQUAD_Q31_FRACTION, saturated);
}

/// What a correction at the section's input does at its output. It fits: the node's scale has room for it.
static inline int32_t biquad_q31_section_correction(const tribo_biquad_q31_section_t *section, int32_t c)
{
    return (int32_t)(uint32_t)((uint64_t)tribo_q31_multiply(section->b0, c) >> BIQUAD_Q31_FRACTION);
}

/// The section's state after a tick. By value: what is written late need not be read twice.
static inline tribo_biquad_q31_section_state_t biquad_q31_section_advance(const tribo_biquad_q31_section_t *section,
                                                                          tribo_biquad_q31_section_state_t  state,
                                                                          int32_t                           in,
                                                                          int32_t                           out)
{
    // Unsigned, as a lost state may wrap.
    uint64_t w1 = (uint64_t)state.w1 + (uint64_t)tribo_q31_shift(state.w2, section->shift);
    w1 += (uint64_t)tribo_q31_multiply(section->b1, in);
    w1 -= (uint64_t)tribo_q31_multiply(section->a1, out);

    const int64_t a2_y = tribo_q31_shift(tribo_q31_multiply(section->a2, out), section->a2_shift);
    uint64_t      w2   = (uint64_t)state.w2 - (uint64_t)a2_y;
    w2 += (uint64_t)tribo_q31_multiply(section->b2, in);
    return (tribo_biquad_q31_section_state_t){.w1 = (int64_t)w1, .w2 = (int64_t)w2};
}

static inline uint32_t biquad_q31_section_excess(tribo_biquad_q31_section_state_t state)
{
    return biquad_q31_excess(state.w1) | biquad_q31_excess(state.w2);
}

/// The input at its node's scale; what that drops is carried.
static inline int32_t biquad_q31_input(const tribo_biquad_q31_params_t *params,
                                       tribo_biquad_q31_state_t        *state,
                                       int32_t                          x)
{
    const uint32_t mask = (UINT32_C(1) << params->input_scale) - 1u;
    const uint32_t rest = ((uint32_t)x & mask) + state->carry;
    state->carry        = rest & mask;
    return (int32_t)((uint32_t)(x >> params->input_scale) + (rest >> params->input_scale)); // a lost carry may wrap
}

/// Two sections, the usual case: y1 at its node's scale for an input at its own.
static inline int32_t biquad_q31_pair_output(const tribo_biquad_q31_params_t *params,
                                             tribo_biquad_q31_state_t        *state,
                                             int32_t                          x,
                                             int32_t                         *y0)
{
    *y0 = biquad_q31_section_output(&params->section[0], state->section[0].w1, x, &state->saturated);
    return biquad_q31_section_output(&params->section[1], state->section[1].w1, *y0, &state->saturated);
}

static inline void biquad_q31_pair_advance(const tribo_biquad_q31_params_t *params,
                                           tribo_biquad_q31_state_t        *state,
                                           int32_t                          x,
                                           int32_t                          y0,
                                           int32_t                          y1,
                                           int32_t                          correction)
{
    uint32_t *const saturated = &state->saturated;
    const int32_t   c0        = biquad_q31_section_correction(&params->section[0], correction);
    const int32_t   c1        = biquad_q31_section_correction(&params->section[1], c0);
    const int32_t   in        = tribo_q31_add(x, correction, saturated);
    const int32_t   out0      = tribo_q31_add(y0, c0, saturated);
    const int32_t   out1      = tribo_q31_add(y1, c1, saturated);

    state->section[0]     = biquad_q31_section_advance(&params->section[0], state->section[0], in, out0);
    state->section[1]     = biquad_q31_section_advance(&params->section[1], state->section[1], out0, out1);
    const uint32_t excess = biquad_q31_section_excess(state->section[0]);
    if ((excess | biquad_q31_section_excess(state->section[1])) >= UINT32_C(1) << 30)
    {
        tribo_biquad_q31_clamp(state);
    }
}

#endif
