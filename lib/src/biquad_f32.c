#include "tribo/biquad_f32.h"

#include "biquad_f32_kernel.h"

#include <stddef.h>

#define INPUT_MAX       1.0e7f
#define COEFFICIENT_MAX 1.0e6f

_Static_assert(offsetof(tribo_biquad_f32_params_t, output_end) ==
                   offsetof(tribo_biquad_f32_params_t, pair_input_end) + sizeof(uint32_t),
               "a pair");

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
    params->count          = count;
    params->pair_input_end = count == 2u ? order_f32(INPUT_MAX) + 1u : 0u;
    params->output_end     = order_f32(BIQUAD_F32_OUTPUT_MAX) + 1u;
    return TRIBO_OK;
}

void tribo_biquad_f32_reset(tribo_biquad_f32_state_t *state)
{
    *state = (tribo_biquad_f32_state_t){.bad_inputs = 0};
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
static inline float unless_lost(tribo_biquad_f32_state_t *state, float y, uint32_t end)
{
    if (TRIBO_RARE(order_f32(y) >= end))
    {
        biquad_f32_start_again(state);
        return 0.0f;
    }
    return y;
}

/// A pair's, for a good input.
static inline float step_of_pair(const tribo_biquad_f32_params_t *params,
                                 tribo_biquad_f32_state_t        *state,
                                 float                            x,
                                 uint32_t                         end)
{
    const tribo_biquad_f32_section_t      *at     = params->section;
    const tribo_biquad_f32_section_t       first  = run_f32_first(&at);
    const run_f32_pair_t                   was    = run_f32_pair(state);
    const float                            y0     = first.b0 * x + was.section[0].w1;
    const tribo_biquad_f32_section_state_t next_0 = biquad_f32_section_advance(&first, was.section[0], x, y0);
    const tribo_biquad_f32_section_t       last   = run_f32_last(&at);
    const float                            y1     = last.b0 * y0 + was.section[1].w1;
    const tribo_biquad_f32_section_state_t next_1 = biquad_f32_section_advance(&last, was.section[1], y0, y1);
    run_f32_keep_pair(state, (run_f32_pair_t){{next_0, next_1}});
    return unless_lost(state, y1, end);
}

static inline float step_of_any(const tribo_biquad_f32_params_t *params, tribo_biquad_f32_state_t *state, float x)
{
    float y = x;
    if (!(magnitude(x) <= INPUT_MAX))
    {
        y = 0.0f;
        count(&state->bad_inputs);
    }
    for (uint32_t i = 0; i < params->count; i++)
    {
        const float in    = y;
        y                 = params->section[i].b0 * in + state->section[i].w1;
        state->section[i] = biquad_f32_section_advance(&params->section[i], state->section[i], in, y);
    }
    return unless_lost(state, y, params->output_end);
}

// No call from here: it would cost every step its registers.
float tribo_biquad_f32_step(const tribo_biquad_f32_params_t *params, tribo_biquad_f32_state_t *state, float x)
{
    const pair_t end = pair_load(&params->pair_input_end); // and of the output
    return TRIBO_FAST_WAY(order_f32(x) < (uint32_t)end.first) ? step_of_pair(params, state, x, (uint32_t)end.second)
                                                              : step_of_any(params, state, x);
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
