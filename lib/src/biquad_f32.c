#include "tribo/biquad_f32.h"

#include "biquad_f32_kernel.h"

#include <stddef.h>

#define INPUT_MAX       1.0e7f
#define COEFFICIENT_MAX 1.0e6f

static tribo_status_t check(const tribo_biquad_f32_section_t *s)
{
    if (exceeds(s->b0, COEFFICIENT_MAX) || exceeds(s->b1, COEFFICIENT_MAX) || exceeds(s->b2, COEFFICIENT_MAX) ||
        exceeds(s->a1, COEFFICIENT_MAX) || exceeds(s->a2, COEFFICIENT_MAX))
    {
        return TRIBO_ERR_SECTION_COEFFICIENT;
    }
    return biquad_f32_inside_or_at_1(s->a1, s->a2) ? TRIBO_OK : TRIBO_ERR_SECTION_UNSTABLE;
}

tribo_status_t tribo_biquad_f32_init(tribo_biquad_f32_params_t        *params,
                                     const tribo_biquad_f32_section_t *sections,
                                     uint32_t                          count)
{
    if (params == NULL || sections == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    if (count < 1u || count > TRIBO_BIQUAD_SECTIONS_MAX)
    {
        return TRIBO_ERR_SECTION_COUNT;
    }
    for (uint32_t i = 0; i < count; i++)
    {
        const tribo_status_t status = check(&sections[i]);
        if (status != TRIBO_OK)
        {
            return status;
        }
    }
    for (uint32_t i = 0; i < count; i++)
    {
        params->section[i] = sections[i];
    }
    params->count = count;
    return TRIBO_OK;
}

static void rest(tribo_biquad_f32_state_t *state)
{
    for (uint32_t i = 0; i < TRIBO_BIQUAD_SECTIONS_MAX; i++)
    {
        state->section[i] = (tribo_biquad_f32_section_state_t){0.0f, 0.0f, 0.0f};
    }
}

void tribo_biquad_f32_reset(tribo_biquad_f32_state_t *state)
{
    rest(state);
    state->bad_inputs = 0;
}

void tribo_biquad_f32_start_again(tribo_biquad_f32_state_t *state)
{
    rest(state);
    count(&state->bad_inputs);
}

float tribo_biquad_f32_output(const tribo_biquad_f32_params_t *params,
                              const tribo_biquad_f32_state_t  *state,
                              float                            x,
                              tribo_biquad_f32_outputs_t      *outputs)
{
    float y = x;
    for (uint32_t i = 0; i < params->count; i++)
    {
        y             = params->section[i].b0 * y + state->section[i].w1;
        outputs->y[i] = y;
    }
    return y;
}

void tribo_biquad_f32_advance(const tribo_biquad_f32_params_t  *params,
                              tribo_biquad_f32_state_t         *state,
                              float                             x,
                              const tribo_biquad_f32_outputs_t *outputs,
                              float                             correction)
{
    float in = x + correction;
    float c  = correction;
    for (uint32_t i = 0; i < params->count; i++)
    {
        c *= params->section[i].b0;
        const float out   = outputs->y[i] + c;
        state->section[i] = biquad_f32_section_advance(&params->section[i], state->section[i], in, out);
        in                = out;
    }
}

/// y, or 0 where the state turns out to be lost.
static inline float unless_lost(tribo_biquad_f32_state_t *state, float y)
{
    if (TRIBO_RARE(exceeds(y, BIQUAD_F32_OUTPUT_MAX)))
    {
        tribo_biquad_f32_start_again(state);
        return 0.0f;
    }
    return y;
}

static float step_of_pair(const tribo_biquad_f32_params_t *params, tribo_biquad_f32_state_t *state, float x)
{
    const biquad_f32_pair_t pair = biquad_f32_pair_output(params, state, x);
    biquad_f32_pair_advance(params, state, &pair);
    return unless_lost(state, pair.y1);
}

/// Out of line, so that a pair does not take its stack.
static TRIBO_OUT_OF_LINE float step_of_any(const tribo_biquad_f32_params_t *params,
                                           tribo_biquad_f32_state_t        *state,
                                           float                            x)
{
    tribo_biquad_f32_outputs_t outputs;
    const float                y = tribo_biquad_f32_output(params, state, x, &outputs);
    tribo_biquad_f32_advance(params, state, x, &outputs, 0.0f);
    return unless_lost(state, y);
}

float tribo_biquad_f32_step(const tribo_biquad_f32_params_t *params, tribo_biquad_f32_state_t *state, float x)
{
    float bounded = x;
    if (TRIBO_RARE(exceeds(x, INPUT_MAX)))
    {
        bounded = 0.0f;
        count(&state->bad_inputs);
    }
    return TRIBO_FAST_WAY(params->count == 2u) ? step_of_pair(params, state, bounded)
                                               : step_of_any(params, state, bounded);
}

void tribo_biquad_f32_change(const tribo_biquad_f32_params_t *from,
                             const tribo_biquad_f32_params_t *to,
                             tribo_biquad_f32_state_t        *state,
                             float                            x,
                             float                            offset)
{
    tribo_biquad_f32_outputs_t were;
    const float                last = tribo_biquad_f32_output(from, state, x, &were) + offset;

    float in = x;
    for (uint32_t i = 0; i < to->count; i++)
    {
        const tribo_biquad_f32_section_t *now = &to->section[i];

        // A section that `from` has not got passes its input on and stands still.
        float out    = in;
        float change = 0.0f;
        if (i < from->count)
        {
            const tribo_biquad_f32_section_t *was = &from->section[i];
            out                                   = were.y[i];
            change = (was->b1 * in - was->a1 * out) + (state->section[i].w2 + state->section[i].w2_carry);
        }
        if (i == to->count - 1u)
        {
            out = last;
        }
        state->section[i].w1       = out - now->b0 * in;
        state->section[i].w2       = change - (now->b1 * in - now->a1 * out);
        state->section[i].w2_carry = 0.0f;
        in                         = out;
    }
}
