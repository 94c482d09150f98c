#include "tribo/biquad_f32.h"

#include "exact_f32.h"

#include <stddef.h>

#define INPUT_MAX       1.0e7f
#define OUTPUT_MAX      1.0e15f // far beyond any sane gain: past it a state is lost, and starts again
#define COEFFICIENT_MAX 1.0e6f

static tribo_status_t check(const tribo_biquad_f32_section_t *s)
{
    if (exceeds(s->b0, COEFFICIENT_MAX) || exceeds(s->b1, COEFFICIENT_MAX) || exceeds(s->b2, COEFFICIENT_MAX) ||
        exceeds(s->a1, COEFFICIENT_MAX) || exceeds(s->a2, COEFFICIENT_MAX))
    {
        return TRIBO_ERR_SECTION_COEFFICIENT;
    }
    // Jury's conditions in the delta operator.
    const bool stable = s->a2 >= 0.0f && s->a2 < s->a1 && (4.0f - 2.0f * s->a1) + s->a2 > 0.0f;
    return stable ? TRIBO_OK : TRIBO_ERR_SECTION_UNSTABLE;
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
        state->section[i].w1       = 0.0f;
        state->section[i].w2       = 0.0f;
        state->section[i].w2_carry = 0.0f;
        state->section[i].y        = 0.0f;
    }
}

void tribo_biquad_f32_reset(tribo_biquad_f32_state_t *state)
{
    rest(state);
    state->bad_inputs = 0;
}

float tribo_biquad_f32_output(const tribo_biquad_f32_params_t *params, tribo_biquad_f32_state_t *state, float x)
{
    float y = x;
    for (uint32_t i = 0; i < params->count; i++)
    {
        y                   = params->section[i].b0 * y + state->section[i].w1;
        state->section[i].y = y;
    }
    if (exceeds(y, OUTPUT_MAX))
    {
        rest(state);
        count(&state->bad_inputs);
        return 0.0f;
    }
    return y;
}

void tribo_biquad_f32_advance(const tribo_biquad_f32_params_t *params,
                              tribo_biquad_f32_state_t        *state,
                              float                            x,
                              float                            correction)
{
    float in = x + correction;
    float c  = correction;
    for (uint32_t i = 0; i < params->count; i++)
    {
        const tribo_biquad_f32_section_t *s = &params->section[i];

        c *= s->b0;
        const float out = state->section[i].y + c;
        const float w2  = state->section[i].w2;

        state->section[i].w1 += (s->b1 * in - s->a1 * out) + w2;

        const float change         = (s->b2 * in - s->a2 * out) + state->section[i].w2_carry;
        const float sum            = w2 + change;
        state->section[i].w2       = sum;
        state->section[i].w2_carry = change - (sum - w2);

        in = out;
    }
}

float tribo_biquad_f32_step(const tribo_biquad_f32_params_t *params, tribo_biquad_f32_state_t *state, float x)
{
    float bounded = x;
    if (exceeds(x, INPUT_MAX))
    {
        bounded = 0.0f;
        count(&state->bad_inputs);
    }
    const float y = tribo_biquad_f32_output(params, state, bounded);
    tribo_biquad_f32_advance(params, state, bounded, 0.0f);
    return y;
}

void tribo_biquad_f32_change(const tribo_biquad_f32_params_t *from,
                             const tribo_biquad_f32_params_t *to,
                             tribo_biquad_f32_state_t        *state,
                             float                            x,
                             float                            offset)
{
    const float last = tribo_biquad_f32_output(from, state, x) + offset;

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
            out                                   = state->section[i].y;
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
