#include "biquad_q31.h"

#include "tribo/controller_f32.h"

#include "../number/fixed_q31.h"
#include "biquad_f32.h"
#include "headroom_q31.h"

#include <stddef.h>

// A zeroed state is half a unit of its output away from rest.
int32_t tribo_biquad_q31_restart(tribo_biquad_q31_section_state_t *state, uint32_t *saturated)
{
    *state = (tribo_biquad_q31_section_state_t){.w1 = BIQUAD_Q31_HALF};
    tribo_q31_count(saturated);
    return 0;
}

void tribo_biquad_q31_reset(tribo_biquad_q31_state_t *state)
{
    for (uint32_t i = 0; i < TRIBO_BIQUAD_SECTIONS_MAX; i++)
    {
        (void)tribo_biquad_q31_restart(&state->section[i], &state->saturated);
    }
    state->carry     = 0;
    state->saturated = 0;
}

/// The number of sections, at most TRIBO_BIQUAD_SECTIONS_MAX even if a bit of params has flipped.
static uint32_t sections(const tribo_biquad_q31_params_t *params)
{
    return params->count < TRIBO_BIQUAD_SECTIONS_MAX ? params->count : TRIBO_BIQUAD_SECTIONS_MAX;
}

int32_t tribo_biquad_q31_long_output(const tribo_biquad_q31_params_t *params,
                                     tribo_biquad_q31_state_t        *state,
                                     int32_t                          x)
{
    uint32_t rest;
    int32_t  y = x;
    for (uint32_t i = 0; i < sections(params); i++)
    {
        y = biquad_q31_section_output(&params->section[i], &state->section[i], y, &rest, &state->saturated);
    }
    return y;
}

// Computes each section's output again, because storing it would take one word per section in every state.
void tribo_biquad_q31_long_advance(const tribo_biquad_q31_params_t *params,
                                   tribo_biquad_q31_state_t        *state,
                                   int32_t                          x,
                                   int32_t                          correction)
{
    uint32_t *const saturated   = &state->saturated;
    uint32_t        not_counted = 0;
    uint32_t        rest;
    int32_t         c  = correction;
    int32_t         y  = x;
    int32_t         in = tribo_q31_add(x, c, saturated);
    for (uint32_t i = 0; i < sections(params); i++)
    {
        const tribo_biquad_q31_section_t *const section = &params->section[i];

        y = biquad_q31_section_output(section, &state->section[i], y, &rest, &not_counted);
        c = i == 0u ? biquad_q31_first_correction(section, c) : biquad_q31_later_correction(section, c);
        const int32_t corrected = tribo_q31_add(y, c, saturated);
        biquad_q31_section_advance(section, &state->section[i], in, corrected, rest, saturated);
        in = corrected;
    }
}

/// x 2^-by for `by` of either sign, clamped to +-BIQUAD_Q31_W_MAX.
static int64_t rescale(int64_t x, int32_t by)
{
    const uint32_t left  = by < 0 ? (uint32_t)-by : 0u;
    const uint32_t right = by > 0 ? (uint32_t)by : 0u;
    const int64_t  max   = BIQUAD_Q31_W_MAX >> left;
    const int64_t  kept  = x >> right;
    return (kept > max ? max : (kept < -max ? -max : kept)) * (INT64_C(1) << left);
}

/// b1 x - a1 y: the change of w1 in a tick, except for w2.
static int64_t moved(const tribo_biquad_q31_section_t *section, int32_t x, int32_t y)
{
    const int32_t b1 = section->c1 + section->b0;
    return (int64_t)b1 * x + (int64_t)section->minus_a1 * y;
}

/// The output of sections i to the last for the input `x` of section i, which is at `scale`. Q31 in 64 bits, not
/// saturated.
static int64_t output_behind(const tribo_biquad_q31_params_t *p,
                             tribo_biquad_q31_state_t        *state,
                             uint32_t                         i,
                             int32_t                          x,
                             uint32_t                         scale)
{
    uint32_t rest;
    for (; i < sections(p); i++)
    {
        x     = biquad_q31_section_output(&p->section[i], &state->section[i], x, &rest, &state->saturated);
        scale = p->section[i].scale;
    }
    return tribo_q31_lift(x, scale);
}

void tribo_biquad_q31_change(const tribo_biquad_q31_params_t *from,
                             const tribo_biquad_q31_params_t *to,
                             tribo_biquad_q31_state_t        *state,
                             int32_t                          x,
                             int32_t                          offset)
{
    uint32_t       from_carry = state->carry; // a copy, because only the next tick advances the carry
    uint32_t       to_carry   = from_carry;
    uint32_t       rest;
    int32_t        from_in    = biquad_q31_input(from, &from_carry, x);
    int32_t        in         = biquad_q31_input(to, &to_carry, x);
    uint32_t       from_scale = from->input_scale;
    const uint32_t from_count = sections(from);
    const uint32_t to_count   = sections(to);
    for (uint32_t i = 0; i < to_count; i++)
    {
        const tribo_biquad_q31_section_t *now = &to->section[i];

        // A section missing in `from` starts as a pass-through at rest.
        int32_t from_out = from_in;
        int64_t change   = 0;
        if (i < from_count)
        {
            const tribo_biquad_q31_section_t *was = &from->section[i];
            from_out   = biquad_q31_section_output(was, &state->section[i], from_in, &rest, &state->saturated);
            from_scale = was->scale;
            // The sum is unsigned because it may wrap if the state is corrupt.
            const int64_t w2 = state->section[i].w2 >> was->shift;
            change           = (int64_t)((uint64_t)moved(was, from_in, from_out) + (uint64_t)w2);
        }
        const int32_t by  = (int32_t)now->scale - (int32_t)from_scale;
        int64_t       out = rescale(from_out, by);
        if (i == to_count - 1u)
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
