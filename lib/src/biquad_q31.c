#include "tribo/biquad_q31.h"

#define FRACTION 28u
#define HALF     (INT64_C(1) << (FRACTION - 1u))
#define W_MAX    ((INT64_C(1) << 61) - 1)

/// w within +-W_MAX. Only a state that was never reached from rest can need it. One compare, of the upper words.
static inline int64_t keep(int64_t w, uint32_t *saturated)
{
    if ((uint32_t)(w >> 32) + (UINT32_C(1) << 29) >= UINT32_C(1) << 30)
    {
        tribo_q31_count(saturated);
        return w < 0 ? -W_MAX : W_MAX;
    }
    return w;
}

void tribo_biquad_q31_reset(tribo_biquad_q31_state_t *state)
{
    for (uint32_t i = 0; i < TRIBO_BIQUAD_Q31_SECTIONS_MAX; i++)
    {
        state->section[i].w1 = 0;
        state->section[i].w2 = 0;
        state->y[i]          = 0;
    }
    state->x         = 0;
    state->carry     = 0;
    state->saturated = 0;
}

int64_t tribo_biquad_q31_output(const tribo_biquad_q31_params_t *params, tribo_biquad_q31_state_t *state, int32_t x)
{
    const int64_t whole = (int64_t)x + state->carry;
    const int32_t input = (int32_t)tribo_q31_shift(whole, params->input_scale);
    state->carry        = (uint32_t)whole & ((UINT32_C(1) << params->input_scale) - 1u);
    state->x            = input;

    int32_t y = input;
    for (uint32_t i = 0; i < params->count; i++)
    {
        const int64_t sum = state->section[i].w1 + tribo_q31_multiply(params->section[i].b0, y) + HALF;
        y                 = tribo_q31_saturate(sum >> FRACTION, &state->saturated);
        state->y[i]       = y;
    }
    return (int64_t)y * (INT64_C(1) << params->section[params->count - 1u].scale);
}

void tribo_biquad_q31_advance(const tribo_biquad_q31_params_t *params,
                              tribo_biquad_q31_state_t        *state,
                              int32_t                          correction)
{
    int32_t in = tribo_q31_saturate((int64_t)state->x + correction, &state->saturated);
    int32_t c  = correction;
    for (uint32_t i = 0; i < params->count; i++)
    {
        const tribo_biquad_q31_section_t *s = &params->section[i];

        c                 = tribo_q31_saturate(tribo_q31_multiply(s->b0, c) >> FRACTION, &state->saturated);
        const int32_t out = tribo_q31_saturate((int64_t)state->y[i] + c, &state->saturated);

        // In this order: w1 takes the old w2.
        int64_t w = state->section[i].w1 + tribo_q31_shift(state->section[i].w2, s->shift);
        w += tribo_q31_multiply(s->b1, in);
        w -= tribo_q31_multiply(s->a1, out);
        state->section[i].w1 = keep(w, &state->saturated);

        w = state->section[i].w2 - tribo_q31_shift(tribo_q31_multiply(s->a2, out), s->a2_shift);
        w += tribo_q31_multiply(s->b2, in);
        state->section[i].w2 = keep(w, &state->saturated);
        in                   = out;
    }
}

int32_t tribo_biquad_q31_step(const tribo_biquad_q31_params_t *params, tribo_biquad_q31_state_t *state, int32_t x)
{
    const int64_t y = tribo_biquad_q31_output(params, state, x);
    tribo_biquad_q31_advance(params, state, 0);
    return tribo_q31_saturate(y, &state->saturated);
}

/// x 2^-by, `by` of either sign, clamped to +-W_MAX.
static int64_t rescale(int64_t x, int32_t by)
{
    const uint32_t left  = by < 0 ? (uint32_t)-by : 0u;
    const uint32_t right = by > 0 ? (uint32_t)by : 0u;
    const int64_t  max   = W_MAX >> left;
    const int64_t  kept  = x >> right;
    return (kept > max ? max : (kept < -max ? -max : kept)) * (INT64_C(1) << left);
}

void tribo_biquad_q31_change(const tribo_biquad_q31_params_t *from,
                             const tribo_biquad_q31_params_t *to,
                             tribo_biquad_q31_state_t        *state,
                             int32_t                          x,
                             int32_t                          offset)
{
    const uint32_t carry = state->carry;
    const int64_t  last  = tribo_biquad_q31_output(from, state, x) + offset;
    state->carry         = carry & ((UINT32_C(1) << to->input_scale) - 1u);

    int32_t from_in    = state->x;
    int32_t in         = (int32_t)(((int64_t)x + state->carry) >> to->input_scale); // what the next tick will make of x
    int32_t from_scale = from->input_scale;
    for (uint32_t i = 0; i < to->count; i++)
    {
        const tribo_biquad_q31_section_t *now = &to->section[i];

        // A section that `from` has not got passes its input on and stands still.
        int32_t from_out = from_in;
        int64_t change   = 0;
        if (i < from->count)
        {
            const tribo_biquad_q31_section_t *was = &from->section[i];
            from_out                              = state->y[i];
            from_scale                            = was->scale;
            change = (int64_t)was->b1 * from_in - (int64_t)was->a1 * from_out + (state->section[i].w2 >> was->shift);
        }
        const int32_t by  = now->scale - from_scale;
        int64_t       out = rescale(from_out, by);
        if (i == to->count - 1u)
        {
            out = rescale(last, now->scale);
        }
        const int32_t y      = tribo_q31_saturate(out, &state->saturated);
        state->section[i].w1 = rescale((int64_t)y * (INT64_C(1) << FRACTION) - (int64_t)now->b0 * in, 0);
        state->section[i].w2 =
            rescale(rescale(change, by) - ((int64_t)now->b1 * in - (int64_t)now->a1 * y), -(int32_t)now->shift);
        from_in = from_out;
        in      = y;
    }
}
