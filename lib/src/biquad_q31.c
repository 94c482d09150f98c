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
    const sum_q31_t input = biquad_q31_input(params, state, x);
    int32_t         y     = (int32_t)sum_q31_high(input);
    state->carry          = sum_q31_low(input);
    outputs->x            = y;
    for (uint32_t i = 0; i < params->count; i++)
    {
        const biquad_q31_node_t out =
            biquad_q31_section_output(&params->section[i], &state->section[i].w1, y, &state->saturated);
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
        c               = output_correction(&params->section[i], i == 0u, c, &state->saturated);
        const int32_t y = tribo_q31_opaque(tribo_q31_add(outputs->y[i], c, &state->saturated));
        (void)biquad_q31_section_advance(&params->section[i],
                                         &state->section[i],
                                         params->section[i].c1,
                                         in,
                                         y,
                                         sum_q31_of(outputs->rest[i], 0),
                                         true,
                                         sum_q31_one());
        biquad_q31_clamp(&state->section[i], &state->saturated);
        in = y;
    }
}

/// y 2^scale, within the symmetric range.
static inline int32_t saturated_output(int32_t y, uint32_t scale, uint32_t *saturated)
{
    const uint32_t most = (uint32_t)INT32_MAX >> scale;
    int32_t        out  = (int32_t)((uint32_t)y << scale);
    if (TRIBO_RARE((uint32_t)y + most > 2u * most))
    {
        tribo_q31_count(saturated);
        out = tribo_q31_symmetric_end(y);
    }
    return out;
}

static inline int32_t section_step(const tribo_biquad_q31_section_t *section,
                                   tribo_biquad_q31_section_state_t *state,
                                   int32_t                           x,
                                   int32_t                           one,
                                   uint32_t                         *excess,
                                   uint32_t                         *saturated)
{
    const pair_t    b0_c1 = pair_load(&section->b0);
    const sum_q31_t sum   = biquad_q31_section_sum(b0_c1.first, &state->w1, x, saturated);
    const int32_t   y     = tribo_q31_opaque(biquad_q31_rounded(sum));
    *excess               = biquad_q31_section_advance(section, state, b0_c1.second, x, y, sum, false, one);
    return y;
}

static inline int32_t step_of_pair(const tribo_biquad_q31_params_t *params, tribo_biquad_q31_state_t *state, int32_t x)
{
    const tribo_biquad_q31_section_t *const s         = params->section;
    uint32_t *const                         saturated = &state->saturated;
    const int32_t                           one       = sum_q31_one();
    uint32_t                                excess_0;
    uint32_t                                excess_1;

    const sum_q31_t input = biquad_q31_pair_input(params, state, x);
    state->carry          = sum_q31_low(input);
    int32_t y = section_step(&s[0], &state->section[0], (int32_t)sum_q31_high(input), one, &excess_0, saturated);
    TRIBO_FROM_HERE();
    y = section_step(&s[1], &state->section[1], y, one, &excess_1, saturated);
    biquad_q31_pair_clamp(state, excess_0, excess_1);
    return saturated_output(y, s[1].scale, saturated);
}

/// Out of line, so that a pair does not take its stack.
static TRIBO_OUT_OF_LINE int32_t step_of_any(const tribo_biquad_q31_params_t *params,
                                             tribo_biquad_q31_state_t        *state,
                                             int32_t                          x)
{
    const uint32_t             last = params->count - 1u;
    tribo_biquad_q31_outputs_t outputs;
    (void)tribo_biquad_q31_output(params, state, x, &outputs);
    tribo_biquad_q31_advance(params, state, &outputs, 0);
    return saturated_output(outputs.y[last], params->section[last].scale, &state->saturated);
}

int32_t tribo_biquad_q31_step(const tribo_biquad_q31_params_t *params, tribo_biquad_q31_state_t *state, int32_t x)
{
    return TRIBO_FAST_WAY(params->pair_power != 0) ? step_of_pair(params, state, x) : step_of_any(params, state, x);
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
static inline int64_t moved(const tribo_biquad_q31_section_t *section, int32_t x, int32_t y)
{
    const int32_t b1 = section->c1 + section->b0;
    return (int64_t)b1 * x + (int64_t)section->minus_a1 * y;
}

/// What the sections of `p` from the i-th on make of `x`, which is at `scale`: the cascade's output, unsaturated.
static inline int64_t output_behind(const tribo_biquad_q31_params_t *p,
                                    tribo_biquad_q31_state_t        *state,
                                    uint32_t                         i,
                                    int32_t                          x,
                                    uint32_t                         scale)
{
    for (; i < p->count; i++)
    {
        x     = biquad_q31_section_output(&p->section[i], &state->section[i].w1, x, &state->saturated).y;
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
    int32_t  from_in    = (int32_t)sum_q31_high(biquad_q31_input(from, state, x));
    int32_t  in         = (int32_t)sum_q31_high(biquad_q31_input(to, state, x)); // what the next tick will make of x
    uint32_t from_scale = from->input_scale;
    for (uint32_t i = 0; i < to->count; i++)
    {
        const tribo_biquad_q31_section_t *now = &to->section[i];

        // A section that `from` has not got passes its input on and stands still.
        int32_t from_out = from_in;
        int64_t change   = 0;
        if (i < from->count)
        {
            const tribo_biquad_q31_section_t *was = &from->section[i];
            from_out   = biquad_q31_section_output(was, &state->section[i].w1, from_in, &state->saturated).y;
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
