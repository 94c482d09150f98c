#include "tribo/biquad_q31.h"

#include "biquad_q31_kernel.h"
#include "usual.h"

void tribo_biquad_q31_reset(tribo_biquad_q31_state_t *state)
{
    for (uint32_t i = 0; i < TRIBO_BIQUAD_Q31_SECTIONS_MAX; i++)
    {
        state->section[i].w1 = BIQUAD_Q31_HALF;
        state->section[i].w2 = 0;
    }
    state->carry     = 0;
    state->saturated = 0;
}

static int64_t unscaled(int32_t y, uint32_t scale)
{
    return (int64_t)y * (INT32_C(1) << scale);
}

int64_t tribo_biquad_q31_output(const tribo_biquad_q31_params_t *params,
                                tribo_biquad_q31_state_t        *state,
                                int32_t                          x,
                                tribo_biquad_q31_outputs_t      *outputs)
{
    int32_t y  = biquad_q31_input(params, state, x);
    outputs->x = y;
    for (uint32_t i = 0; i < params->count; i++)
    {
        const biquad_q31_node_t out =
            biquad_q31_section_output(&params->section[i], state->section[i].w1, y, &state->saturated);
        y                = out.y;
        outputs->y[i]    = y;
        outputs->rest[i] = out.rest;
    }
    return unscaled(y, params->section[params->count - 1u].scale);
}

/// What a correction at a section's input does at its output.
static int32_t output_correction(const tribo_biquad_q31_section_t *section, bool first, int32_t c, uint32_t *saturated)
{
    if (first)
    {
        return tribo_q31_widen(biquad_q31_first_correction(section, c), BIQUAD_Q31_CORRECTION, saturated);
    }
    return tribo_q31_narrow(tribo_q31_multiply(section->b0, c), BIQUAD_Q31_FRACTION, saturated);
}

void tribo_biquad_q31_advance(const tribo_biquad_q31_params_t  *params,
                              tribo_biquad_q31_state_t         *state,
                              const tribo_biquad_q31_outputs_t *outputs,
                              int32_t                           correction)
{
    int32_t in = tribo_q31_add(outputs->x, correction, &state->saturated);
    int32_t c  = correction;
    for (uint32_t i = 0; i < params->count; i++)
    {
        c                           = output_correction(&params->section[i], i == 0u, c, &state->saturated);
        const biquad_q31_node_t out = {.y    = tribo_q31_add(outputs->y[i], c, &state->saturated),
                                       .rest = outputs->rest[i]};
        state->section[i]           = biquad_q31_section_advance(&params->section[i], state->section[i].w2, in, out);
        biquad_q31_clamp(&state->section[i], &state->saturated);
        in = out.y;
    }
}

static int32_t step_of_pair(const tribo_biquad_q31_params_t *params, tribo_biquad_q31_state_t *state, int32_t x)
{
    const biquad_q31_pair_t pair = biquad_q31_pair_output(params, state, x);
    biquad_q31_pair_advance(params, state, &pair);
    return tribo_q31_saturate(unscaled(pair.out[1].y, params->section[1].scale), &state->saturated);
}

/// Out of line, so that a pair does not take its stack.
static TRIBO_OUT_OF_LINE int32_t step_of_any(const tribo_biquad_q31_params_t *params,
                                             tribo_biquad_q31_state_t        *state,
                                             int32_t                          x)
{
    tribo_biquad_q31_outputs_t outputs;
    const int64_t              y = tribo_biquad_q31_output(params, state, x, &outputs);
    tribo_biquad_q31_advance(params, state, &outputs, 0);
    return tribo_q31_saturate(y, &state->saturated);
}

int32_t tribo_biquad_q31_step(const tribo_biquad_q31_params_t *params, tribo_biquad_q31_state_t *state, int32_t x)
{
    return TRIBO_FAST_WAY(params->count == 2u) ? step_of_pair(params, state, x) : step_of_any(params, state, x);
}

/// x 2^-by, `by` of either sign, clamped to +-BIQUAD_Q31_W_MAX.
static TRIBO_OUT_OF_LINE int64_t rescale(int64_t x, int32_t by)
{
    const uint32_t left  = by < 0 ? (uint32_t)-by : 0u;
    const uint32_t right = by > 0 ? (uint32_t)by : 0u;
    const int64_t  max   = BIQUAD_Q31_W_MAX >> left;
    const int64_t  kept  = x >> right;
    return (kept > max ? max : (kept < -max ? -max : kept)) * (INT64_C(1) << left);
}

/// What a tick adds to w1 but for w2, b1 x - a1 y.
static TRIBO_OUT_OF_LINE int64_t moved(const tribo_biquad_q31_section_t *section, int32_t x, int32_t y)
{
    const int32_t b1 = section->c1 + section->b0;
    const int32_t a1 = (INT32_C(1) << BIQUAD_Q31_FRACTION) - section->d1;
    return (int64_t)b1 * x - (int64_t)a1 * y;
}

/// What the sections of `p` from the i-th on make of `x`, which is at `scale`: the cascade's output, unsaturated.
static TRIBO_OUT_OF_LINE int64_t output_behind(const tribo_biquad_q31_params_t *p,
                                               tribo_biquad_q31_state_t        *state,
                                               uint32_t                         i,
                                               int32_t                          x,
                                               uint32_t                         scale)
{
    for (; i < p->count; i++)
    {
        x     = biquad_q31_section_output(&p->section[i], state->section[i].w1, x, &state->saturated).y;
        scale = p->section[i].scale;
    }
    return unscaled(x, scale);
}

void tribo_biquad_q31_change(const tribo_biquad_q31_params_t *from,
                             const tribo_biquad_q31_params_t *to,
                             tribo_biquad_q31_state_t        *state,
                             int32_t                          x,
                             int32_t                          offset)
{
    const uint32_t carry   = state->carry;
    int32_t        from_in = biquad_q31_input(from, state, x);
    state->carry           = carry;
    int32_t in             = biquad_q31_input(to, state, x); // what the next tick will make of x
    state->carry           = carry;
    uint32_t from_scale    = from->input_scale;
    for (uint32_t i = 0; i < to->count; i++)
    {
        const tribo_biquad_q31_section_t *now = &to->section[i];

        // A section that `from` has not got passes its input on and stands still.
        int32_t from_out = from_in;
        int64_t change   = 0;
        if (i < from->count)
        {
            const tribo_biquad_q31_section_t *was = &from->section[i];
            from_out   = biquad_q31_section_output(was, state->section[i].w1, from_in, &state->saturated).y;
            from_scale = was->scale;
            // Unsigned, as a lost state may wrap.
            const int64_t w2 = state->section[i].w2 >> was->shift;
            change           = (int64_t)((uint64_t)moved(was, from_in, from_out) + (uint64_t)w2);
        }
        const int32_t by  = (int32_t)now->scale - (int32_t)from_scale;
        int64_t       out = rescale(from_out, by);
        if (i == to->count - 1u)
        {
            out = rescale(output_behind(from, state, i + 1u, from_out, from_scale) + offset, now->scale);
        }
        const int32_t y = tribo_q31_saturate(out, &state->saturated);
        state->section[i].w1 =
            rescale((int64_t)y * (INT64_C(1) << BIQUAD_Q31_FRACTION) - (int64_t)now->b0 * in + BIQUAD_Q31_HALF, 0);
        state->section[i].w2 = rescale(rescale(change, by) - moved(now, in, y), -(int32_t)now->shift);
        from_in              = from_out;
        in                   = y;
    }
}
