// One tick of a cascade, in two halves: the outputs, then the states. Between the two a controller limits its output and
// corrects what the states see. biquad_q31.h has the equations and the formats.

#ifndef TRIBO_BIQUAD_Q31_STEP_H
#define TRIBO_BIQUAD_Q31_STEP_H

#include "tribo/biquad_q31.h"

#define BIQUAD_Q31_FRACTION 28u // of the coefficients
#define BIQUAD_Q31_ONE      (INT32_C(1) << BIQUAD_Q31_FRACTION)
#define BIQUAD_Q31_HALF     (INT64_C(1) << (BIQUAD_Q31_FRACTION - 1u))
#define BIQUAD_Q31_W_MAX    ((INT64_C(1) << 61) - 1)

/// a + b c, unsigned inside, as a corrupt state may wrap.
static inline int64_t biquad_q31_accumulate(int64_t a, int32_t b, int32_t c)
{
    return (int64_t)((uint64_t)a + (uint64_t)tribo_q31_multiply(b, c));
}

/// x at the scale of the input node. The bits that this drops are carried into the next sample.
static inline int32_t biquad_q31_input(const tribo_biquad_q31_params_t *params, uint32_t *carry, int32_t x)
{
    const uint32_t dropped = (uint32_t)x << (31u - params->input_scale) << 1; // at bit 31; none at scale 0
    const uint32_t sum     = *carry + dropped;
    const uint32_t carried = sum < dropped ? 1u : 0u;
    *carry                 = sum;
    return (int32_t)((uint32_t)(x >> params->input_scale) + carried);
}

/// A section's output, y = w1 + b0 x, rounded down; the rest stays in w1.
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

/// A section's states, for the input and output that it is to have seen.
static inline void biquad_q31_section_advance(const tribo_biquad_q31_section_t *section,
                                              tribo_biquad_q31_section_state_t *state,
                                              int32_t                           in,
                                              int32_t                           y,
                                              uint32_t                          rest,
                                              uint32_t                         *saturated)
{
    // w1 + b0 x is 2^28 y + rest: a product with 1 more than -a1 adds it.
    int64_t w1 = biquad_q31_accumulate(rest, section->c1, in);
    w1         = biquad_q31_accumulate(w1, section->minus_a1 + BIQUAD_Q31_ONE, y);
    state->w1  = (int64_t)((uint64_t)w1 + (uint64_t)tribo_q31_shift(state->w2, section->shift));

    int64_t w2 = biquad_q31_accumulate(state->w2, section->c2, in);
    w2         = biquad_q31_accumulate(w2, section->d2, y);
    w2         = (int64_t)((uint64_t)w2 + (uint64_t)(tribo_q31_multiply(section->d2_low, y) >> 32));
    // Only a state that was never reached from rest gets beyond W_MAX; w1 is bounded with y.
    const uint32_t high = (uint32_t)((uint64_t)w2 >> 32);
    if (high + (UINT32_C(1) << 29) >= UINT32_C(1) << 30)
    {
        w2 = w2 < 0 ? -BIQUAD_Q31_W_MAX : BIQUAD_Q31_W_MAX;
        tribo_q31_count(saturated);
    }
    state->w2 = w2;
}

// Sections beyond the first two, which all cascades have (tribo_biquad_f32_init); out of line, as few have more. Between the
// halves of a tick their outputs are in the state.

int32_t tribo_biquad_q31_further_output(const tribo_biquad_q31_params_t *params,
                                        tribo_biquad_q31_state_t        *state,
                                        int32_t                          x);
void    tribo_biquad_q31_further_correct(const tribo_biquad_q31_params_t *params,
                                         tribo_biquad_q31_state_t        *state,
                                         int32_t                          correction);
void    tribo_biquad_q31_further_advance(const tribo_biquad_q31_params_t *params,
                                         tribo_biquad_q31_state_t        *state,
                                         int32_t                          x);

/// The nodes of the cascade for input `x`; returns the last one, at its scale.
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

/// The nodes as if the input node had been `correction` larger: it goes on through the direct feedthrough b0 of each
/// section to the outputs. It fits at each node.
static inline void biquad_q31_correct(const tribo_biquad_q31_params_t *params,
                                      tribo_biquad_q31_state_t        *state,
                                      tribo_biquad_q31_outputs_t      *outputs,
                                      int32_t                          correction)
{
    const tribo_biquad_q31_section_t *const s         = params->section;
    uint32_t *const                         saturated = &state->saturated;

    // In units of 16 at the first section, which a correction can afford there; later poles may be slow.
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

/// The states of all sections after a tick with these nodes.
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
