#include "biquad_f32.h"

#include "tribo/controller_f32.h"

#include "../number/ranges.h"

#include <stddef.h>

#define INPUT_MAX 4.0e6f // larger than gain f^ and r - y of an accepted loop, N

#define NUMBER(...) PARAMETERS_ELEMENT(tribo_biquad_f32_section_t, __VA_ARGS__)
const tribo_parameter_t tribo_section_numbers[] = {TRIBO_SECTION_ELEMENTS(NUMBER)};
#undef NUMBER

static tribo_status_t check(const tribo_biquad_f32_section_t *s, uint32_t index, tribo_refusal_t *refusal)
{
    const uint32_t       count  = sizeof tribo_section_numbers / sizeof tribo_section_numbers[0];
    const tribo_status_t status = tribo_element_check(tribo_section_numbers, count, s, index, refusal);
    return status != TRIBO_OK || biquad_f32_is_inside_or_at_1(s->a1, s->a2)
               ? status
               : tribo_element_refuse(TRIBO_ERR_SECTION_UNSTABLE, tribo_section_numbers, 3, s, index, refusal); // a1
}

tribo_status_t tribo_biquad_f32_init(tribo_biquad_f32_params_t        *params,
                                     const tribo_biquad_f32_section_t *sections,
                                     uint32_t                          count,
                                     tribo_refusal_t                  *refusal)
{
    if (count < 1u ||
        count > TRIBO_BIQUAD_SECTIONS_MAX) // checked before the pointers: a config without sections has neither
    {
        return TRIBO_ERR_SECTION_COUNT;
    }
    if (params == NULL || sections == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    for (uint32_t i = 0; i < count; i++)
    {
        const tribo_status_t status = check(&sections[i], i, refusal);
        if (status != TRIBO_OK)
        {
            return status;
        }
    }
    tribo_biquad_f32_fill(params, sections, count);
    return TRIBO_OK;
}

void tribo_biquad_f32_fill(tribo_biquad_f32_params_t        *params,
                           const tribo_biquad_f32_section_t *sections,
                           uint32_t                          count)
{
    // A step computes two sections at least, so a lone one is followed by a pass-through: b0 = 1 with zeros and poles
    // at z = 0, whose states stay exactly 0.
    params->section[1] = (tribo_biquad_f32_section_t){.b0 = 1.0f, .b1 = 2.0f, .b2 = 1.0f, .a1 = 2.0f, .a2 = 1.0f};
    params->count      = count > 2u ? count : 2u;
    for (uint32_t i = 0; i < count; i++)
    {
        params->section[i] = sections[i];
    }
}

void tribo_biquad_f32_reset(tribo_biquad_f32_state_t *state)
{
    *state = (tribo_biquad_f32_state_t){.bad_inputs = 0};
}

/// The number of sections, at most TRIBO_BIQUAD_SECTIONS_MAX even if a bit of params has flipped.
static uint32_t sections(const tribo_biquad_f32_params_t *params)
{
    return params->count < TRIBO_BIQUAD_SECTIONS_MAX ? params->count : TRIBO_BIQUAD_SECTIONS_MAX;
}

float tribo_biquad_f32_long_output(const tribo_biquad_f32_params_t *params, tribo_biquad_f32_state_t *state, float x)
{
    float y = x;
    for (uint32_t i = 0; i < sections(params); i++)
    {
        y = biquad_f32_section_output(&params->section[i], &state->section[i], y);
    }
    return y;
}

// Computes each section's output again, because storing it would take one word per section in every state.
void tribo_biquad_f32_long_advance(const tribo_biquad_f32_params_t *params,
                                   tribo_biquad_f32_state_t        *state,
                                   float                            x,
                                   float                            correction)
{
    float in = x + correction;
    float y  = x;
    float c  = correction;
    for (uint32_t i = 0; i < sections(params); i++)
    {
        y = biquad_f32_section_output(&params->section[i], &state->section[i], y);
        c *= params->section[i].b0;
        const float corrected = y + c;
        biquad_f32_section_advance(&params->section[i], &state->section[i], in, corrected);
        in = corrected;
    }
}

void tribo_biquad_f32_change(const tribo_biquad_f32_params_t *from,
                             const tribo_biquad_f32_params_t *to,
                             tribo_biquad_f32_state_t        *state,
                             float                            x,
                             float                            offset)
{
    float          from_out[TRIBO_BIQUAD_SECTIONS_MAX];
    float          in         = exceeds(x, INPUT_MAX) ? 0.0f : x;
    float          last       = in;
    const uint32_t from_count = sections(from);
    const uint32_t to_count   = sections(to);
    for (uint32_t i = 0; i < from_count; i++)
    {
        last        = biquad_f32_section_output(&from->section[i], &state->section[i], last);
        from_out[i] = last;
    }
    last += exceeds(offset, INPUT_MAX) ? 0.0f : offset;

    for (uint32_t i = 0; i < to_count; i++)
    {
        const tribo_biquad_f32_section_t *now = &to->section[i];

        // A section missing in `from` starts as a pass-through at rest.
        float out    = in;
        float change = 0.0f;
        if (i < from_count)
        {
            const tribo_biquad_f32_section_t *was = &from->section[i];
            out                                   = from_out[i];
            change = (was->b1 * in - was->a1 * out) + (state->section[i].w2 + state->section[i].w2_carry);
        }
        if (i == to_count - 1u)
        {
            out = last;
        }
        state->section[i].w1       = out - now->b0 * in;
        state->section[i].w2       = change - (now->b1 * in - now->a1 * out);
        state->section[i].w2_carry = 0.0f;
        in                         = out;
    }
}
