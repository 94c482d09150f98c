// What a tick of a cascade is made of, inline.

#ifndef TRIBO_BIQUAD_Q31_KERNEL_H
#define TRIBO_BIQUAD_Q31_KERNEL_H

#include "tribo/biquad_q31.h"

#define BIQUAD_Q31_FRACTION   28u
#define BIQUAD_Q31_HALF       (INT64_C(1) << (BIQUAD_Q31_FRACTION - 1u))
#define BIQUAD_Q31_CORRECTION (32u - BIQUAD_Q31_FRACTION)
#define BIQUAD_Q31_W_MAX      ((INT64_C(1) << 61) - 1)

/// Below 2^30 while w is within +-W_MAX: or-ed together, one compare serves all states.
static inline uint32_t biquad_q31_excess(int64_t w)
{
    return (uint32_t)((uint64_t)w >> 32) + (UINT32_C(1) << 29);
}

/// w2 within +-W_MAX, counted if it was not. Only a state that was never reached from rest can need it; w1 is made anew
/// each tick. Inline, as a call would cost every tick its registers.
static inline void biquad_q31_clamp(tribo_biquad_q31_section_state_t *section, uint32_t *saturated)
{
    if (biquad_q31_excess(section->w2) >= UINT32_C(1) << 30)
    {
        tribo_q31_count(saturated);
        section->w2 = section->w2 < 0 ? -BIQUAD_Q31_W_MAX : BIQUAD_Q31_W_MAX;
    }
}

/// The input at its node's scale; what that drops is carried.
static inline int32_t biquad_q31_input(const tribo_biquad_q31_params_t *params,
                                       tribo_biquad_q31_state_t        *state,
                                       int32_t                          x)
{
    const uint32_t dropped = (uint32_t)x << (32u - params->input_scale);
    const uint32_t carry   = state->carry + dropped;
    state->carry           = carry;
    return (x >> params->input_scale) + (int32_t)(carry < dropped);
}

/// A section's output: y, and what its rounding leaves.
typedef struct
{
    int32_t  y;
    uint32_t rest;
} biquad_q31_node_t;

static inline biquad_q31_node_t biquad_q31_section_output(const tribo_biquad_q31_section_t *section,
                                                          int64_t                           w1,
                                                          int32_t                           x,
                                                          uint32_t                         *saturated)
{
    // Unsigned, as a lost state may wrap.
    const uint64_t sum = (uint64_t)w1 + (uint64_t)tribo_q31_multiply(section->b0, x);
    return (biquad_q31_node_t){.y    = tribo_q31_opaque(tribo_q31_narrow((int64_t)sum, BIQUAD_Q31_FRACTION, saturated)),
                               .rest = (uint32_t)sum & ((UINT32_C(1) << BIQUAD_Q31_FRACTION) - 1u)};
}

/// What a correction at the first section's input does at its output, over 2^CORRECTION. Shorter than all of it, which later
/// nodes get, as their poles may be slow.
static inline int32_t biquad_q31_first_correction(const tribo_biquad_q31_section_t *section, int32_t c)
{
    return (int32_t)(tribo_q31_multiply(section->b0, c) >> 32);
}

/// The section's state after a tick. By value: what is written late need not be read twice.
static inline tribo_biquad_q31_section_state_t biquad_q31_section_advance(const tribo_biquad_q31_section_t *section,
                                                                          int64_t                           w2,
                                                                          int32_t                           in,
                                                                          biquad_q31_node_t                 out)
{
    // Unsigned, as a lost state may wrap.
    uint64_t next = (uint64_t)w2 + (uint64_t)tribo_q31_multiply(section->c2, in);
    next += (uint64_t)tribo_q31_multiply(section->d2, out.y);
    next += (uint64_t)(tribo_q31_multiply(section->d2_low, out.y) >> 32);

    uint64_t w1 = out.rest + (uint64_t)tribo_q31_multiply(section->d1, out.y);
    w1 += (uint64_t)tribo_q31_multiply(section->c1, in);
    w1 = tribo_q31_add_shifted(w1, w2, section->shift, section->shift_power);
    return (tribo_biquad_q31_section_state_t){.w1 = (int64_t)w1, .w2 = (int64_t)next};
}

/// The nodes of a pair of sections.
typedef struct
{
    int32_t           x; ///< the input, at its node's scale
    biquad_q31_node_t out[2];
} biquad_q31_pair_t;

static inline biquad_q31_pair_t biquad_q31_pair_output(const tribo_biquad_q31_params_t *params,
                                                       tribo_biquad_q31_state_t        *state,
                                                       int32_t                          x)
{
    uint32_t *const   saturated = &state->saturated;
    biquad_q31_pair_t pair      = {.x = biquad_q31_input(params, state, x)};
    pair.out[0] = biquad_q31_section_output(&params->section[0], state->section[0].w1, pair.x, saturated);
    pair.out[1] = biquad_q31_section_output(&params->section[1], state->section[1].w1, pair.out[0].y, saturated);
    return pair;
}

/// `pair` as if its input had been `correction` larger, for one that fits any node. The nodes have room for both but after
/// a change of params.
static inline void biquad_q31_pair_correct(const tribo_biquad_q31_params_t *params,
                                           tribo_biquad_q31_state_t        *state,
                                           biquad_q31_pair_t               *pair,
                                           int32_t                          correction)
{
    uint32_t *const saturated = &state->saturated;
    const int32_t   c0 = biquad_q31_first_correction(&params->section[0], correction) * (1 << BIQUAD_Q31_CORRECTION);
    const int32_t   c1 = (int32_t)(tribo_q31_multiply(params->section[1].b0, c0) >> BIQUAD_Q31_FRACTION);
    pair->x            = tribo_q31_add(pair->x, correction, saturated);
    pair->out[0].y     = tribo_q31_add(pair->out[0].y, c0, saturated);
    pair->out[1].y     = tribo_q31_add(pair->out[1].y, c1, saturated);
}

static inline void biquad_q31_pair_advance(const tribo_biquad_q31_params_t *params,
                                           tribo_biquad_q31_state_t        *state,
                                           const biquad_q31_pair_t         *pair)
{
    const tribo_biquad_q31_section_t *s = params->section;

    state->section[0] = biquad_q31_section_advance(&s[0], state->section[0].w2, pair->x, pair->out[0]);
    state->section[1] = biquad_q31_section_advance(&s[1], state->section[1].w2, pair->out[0].y, pair->out[1]);
    if ((biquad_q31_excess(state->section[0].w2) | biquad_q31_excess(state->section[1].w2)) >= UINT32_C(1) << 30)
    {
        biquad_q31_clamp(&state->section[0], &state->saturated);
        biquad_q31_clamp(&state->section[1], &state->saturated);
    }
}

#endif
