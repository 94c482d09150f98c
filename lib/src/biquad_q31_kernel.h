// What a tick of a cascade is made of, inline.

#ifndef TRIBO_BIQUAD_Q31_KERNEL_H
#define TRIBO_BIQUAD_Q31_KERNEL_H

#include "tribo/biquad_q31.h"

#include "sum_q31.h"
#include "usual.h"

#include <stdbool.h>
#include <stddef.h>

#define BIQUAD_Q31_FRACTION   28u
#define BIQUAD_Q31_HALF       (INT64_C(1) << (BIQUAD_Q31_FRACTION - 1u))
#define BIQUAD_Q31_CORRECTION (32u - BIQUAD_Q31_FRACTION)
#define BIQUAD_Q31_W_MAX      ((INT64_C(1) << 61) - 1)

// What pair_load reads at once.
#define BIQUAD_Q31_ARE_NEIGHBOURS(field, next)                                                                         \
    (offsetof(tribo_biquad_q31_section_t, next) == offsetof(tribo_biquad_q31_section_t, field) + sizeof(int32_t))
_Static_assert(BIQUAD_Q31_ARE_NEIGHBOURS(b0, c1) && BIQUAD_Q31_ARE_NEIGHBOURS(minus_a1, c2) &&
                   BIQUAD_Q31_ARE_NEIGHBOURS(d2, d2_low) && BIQUAD_Q31_ARE_NEIGHBOURS(shift_power, shift),
               "pairs");

/// Below 2^30 while w is within +-W_MAX: or-ed together, one compare serves all states.
static inline uint32_t biquad_q31_excess(uint32_t high)
{
    return high + (UINT32_C(1) << 29);
}

/// w2 within +-W_MAX, counted if it was not. Only a state that was never reached from rest can need it; w1 is bounded
/// with y. Inline, as a call would cost every tick its registers.
static inline void biquad_q31_clamp(tribo_biquad_q31_section_state_t *section, uint32_t *saturated)
{
    if (biquad_q31_excess((uint32_t)((uint64_t)section->w2 >> 32)) >= UINT32_C(1) << 30)
    {
        tribo_q31_count(saturated);
        section->w2 = section->w2 < 0 ? -BIQUAD_Q31_W_MAX : BIQUAD_Q31_W_MAX;
    }
}

/// The input at its node's scale in the high word; in the low one what that drops, which is to be carried.
static inline sum_q31_t biquad_q31_input(const tribo_biquad_q31_params_t *params,
                                         const tribo_biquad_q31_state_t  *state,
                                         int32_t                          x)
{
    const uint32_t dropped = (uint32_t)x << (32u - params->input_scale);
    const uint32_t carry   = state->carry + dropped;
    return sum_q31_of(carry, (uint32_t)(x >> params->input_scale) + (uint32_t)(carry < dropped));
}

/// The same of two sections.
static inline sum_q31_t biquad_q31_pair_input(const tribo_biquad_q31_params_t *params,
                                              const tribo_biquad_q31_state_t  *state,
                                              int32_t                          x)
{
#ifdef TRIBO_Q31_SHORT_PRODUCTS
    return biquad_q31_input(params, state, x);
#else
    return sum_q31_accumulate(sum_q31_of(state->carry, 0), x, params->pair_power);
#endif
}

/// What its rounding leaves of a sum.
static inline uint32_t biquad_q31_rest(sum_q31_t sum)
{
    return sum_q31_low(sum) & ((UINT32_C(1) << BIQUAD_Q31_FRACTION) - 1u);
}

/// What is rounded to y and leaves `rest`.
static inline sum_q31_t biquad_q31_unrounded(int32_t y, uint32_t rest)
{
    return sum_q31_of((uint32_t)y << BIQUAD_Q31_FRACTION | rest, (uint32_t)(y >> (32u - BIQUAD_Q31_FRACTION)));
}

static inline int32_t biquad_q31_rounded(sum_q31_t sum)
{
    return (int32_t)(sum_q31_high(sum) << (32u - BIQUAD_Q31_FRACTION) | sum_q31_low(sum) >> BIQUAD_Q31_FRACTION);
}

/// A section's output before its rounding, within what fits. Unsigned, as a lost state may wrap.
static inline sum_q31_t biquad_q31_section_sum(int32_t b0, const int64_t *w1, int32_t x, uint32_t *saturated)
{
    sum_q31_t sum = sum_q31_settle(sum_q31_accumulate(sum_q31_load(w1), b0, x));
    if (sum_q31_is_beyond(sum, BIQUAD_Q31_FRACTION))
    {
        tribo_q31_count(saturated);
        const int32_t y = tribo_q31_end((int32_t)sum_q31_high(sum));
        sum             = biquad_q31_unrounded(y, biquad_q31_rest(sum));
    }
    return sum;
}

/// What a correction at the first section's input does at its output, over 2^CORRECTION. Shorter than all of it, which later
/// nodes get, as their poles may be slow.
static inline int32_t biquad_q31_first_correction(const tribo_biquad_q31_section_t *section, int32_t c)
{
    return (int32_t)(tribo_q31_multiply(section->b0, c) >> 32);
}

/// shift_power, and shift in the low byte of a word.
static inline pair_t biquad_q31_power_shift(const tribo_biquad_q31_section_t *section)
{
#ifdef TRIBO_THUMB2
    return pair_load(&section->shift_power); // and what stands behind it, at once
#else
    return (pair_t){.first = section->shift_power, .second = section->shift};
#endif
}

/// The section's state after a tick. `left` is what w1 has of the output: its sum or, where y is no longer what that was
/// rounded to, `of_y`, a constant, being true, its rest. Returns the excess of w2.
static inline uint32_t biquad_q31_section_advance(const tribo_biquad_q31_section_t *section,
                                                  tribo_biquad_q31_section_state_t *state,
                                                  int32_t                           c1,
                                                  int32_t                           in,
                                                  int32_t                           y,
                                                  sum_q31_t                         left,
                                                  bool                              of_y,
                                                  int32_t                           one)
{
    const int32_t all_y = of_y ? INT32_C(1) << BIQUAD_Q31_FRACTION : 0;
    const pair_t  a1_c2 = pair_load(&section->minus_a1);
    sum_q31_t     w1    = sum_q31_accumulate(left, c1, in);
    w1                  = sum_q31_settle(sum_q31_accumulate(w1, a1_c2.first + all_y, y));

    // One after the other, where registers are short.
    TRIBO_FROM_HERE();
    const pair_t power_shift = biquad_q31_power_shift(section);
    sum_q31_t    w2          = sum_q31_load(&state->w2);
    w1                       = sum_q31_add_shifted(w1, w2, power_shift, one);
    sum_q31_store(&state->w1, w1);

    TRIBO_FROM_HERE();
    const pair_t d2 = pair_load(&section->d2);
    w2              = sum_q31_accumulate(w2, a1_c2.second, in);
    w2              = sum_q31_accumulate(w2, d2.first, y);
    w2              = sum_q31_add_signed(w2, (int32_t)(tribo_q31_multiply(d2.second, y) >> 32), one);
    sum_q31_store(&state->w2, w2);
    return biquad_q31_excess(sum_q31_high(w2));
}

/// w2 of two sections within +-W_MAX.
static inline void biquad_q31_pair_clamp(tribo_biquad_q31_state_t *state, uint32_t excess_0, uint32_t excess_1)
{
    if (TRIBO_RARE((excess_0 | excess_1) >= UINT32_C(1) << 30))
    {
        biquad_q31_clamp(&state->section[0], &state->saturated);
        biquad_q31_clamp(&state->section[1], &state->saturated);
    }
}

/// A section's output: y, and what its rounding leaves.
typedef struct
{
    int32_t  y;
    uint32_t rest;
} biquad_q31_node_t;

/// Not by way of biquad_q31_section_sum: a sum is a word more to keep until the state advances.
static inline biquad_q31_node_t biquad_q31_section_output(const tribo_biquad_q31_section_t *section,
                                                          const int64_t                    *w1,
                                                          int32_t                           x,
                                                          uint32_t                         *saturated)
{
    const sum_q31_t sum = sum_q31_accumulate(sum_q31_load(w1), section->b0, x);
    int32_t         y   = biquad_q31_rounded(sum);
    if (sum_q31_is_beyond(sum, BIQUAD_Q31_FRACTION))
    {
        tribo_q31_count(saturated);
        y = tribo_q31_end((int32_t)sum_q31_high(sum));
    }
    return (biquad_q31_node_t){.y = tribo_q31_opaque(y), .rest = biquad_q31_rest(sum)};
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
    const sum_q31_t   input     = biquad_q31_pair_input(params, state, x);
    biquad_q31_pair_t pair      = {.x = (int32_t)sum_q31_high(input)};

    state->carry = sum_q31_low(input);
    pair.out[0]  = biquad_q31_section_output(&params->section[0], &state->section[0].w1, pair.x, saturated);
    pair.out[1]  = biquad_q31_section_output(&params->section[1], &state->section[1].w1, pair.out[0].y, saturated);
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
    const tribo_biquad_q31_section_t *const s   = params->section;
    const biquad_q31_node_t *const          out = pair->out;
    const int32_t                           one = sum_q31_one();

    const uint32_t excess_0 = biquad_q31_section_advance(&s[0],
                                                         &state->section[0],
                                                         s[0].c1,
                                                         pair->x,
                                                         out[0].y,
                                                         sum_q31_of(out[0].rest, 0),
                                                         true,
                                                         one);
    TRIBO_FROM_HERE();
    const uint32_t excess_1 = biquad_q31_section_advance(&s[1],
                                                         &state->section[1],
                                                         s[1].c1,
                                                         out[0].y,
                                                         out[1].y,
                                                         sum_q31_of(out[1].rest, 0),
                                                         true,
                                                         one);
    biquad_q31_pair_clamp(state, excess_0, excess_1);
}

#endif
