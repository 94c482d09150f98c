// One tick of a cascade, in two halves: the outputs, then the states. Between the two a controller limits its output and
// corrects what the states see. For an input that is known to be good.

#ifndef TRIBO_BIQUAD_F32_STEP_H
#define TRIBO_BIQUAD_F32_STEP_H

#include "tribo/biquad_f32.h"

#include "ieee_f32.h"

#define BIQUAD_F32_OUTPUT_MAX 1.0e15f // no sane gain gets there: the state is corrupt

/// y = b0 x + w1.
static inline float biquad_f32_section_output(const tribo_biquad_f32_section_t       *section,
                                              const tribo_biquad_f32_section_state_t *state,
                                              float                                   x)
{
    return section->b0 * x + state->w1;
}

/// w1 and w2 for the input and output that the section is to have seen.
static inline void biquad_f32_section_advance(const tribo_biquad_f32_section_t *section,
                                              tribo_biquad_f32_section_state_t *state,
                                              float                             in,
                                              float                             out)
{
    const float w2_before = state->w2;
    const float change    = (section->b2 * in - section->a2 * out) + state->w2_carry;
    const float w2        = w2_before + change;

    state->w1 += (section->b1 * in - section->a1 * out) + w2_before;
    state->w2       = w2;
    state->w2_carry = change - (w2 - w2_before); // what the sum has rounded off
}

// Sections beyond the first two, which all cascades have (tribo_biquad_f32_init); out of line, as few have more. Between the
// halves of a tick their outputs are in the state.

float tribo_biquad_f32_further_output(const tribo_biquad_f32_params_t *params,
                                      tribo_biquad_f32_state_t        *state,
                                      float                            x);
void  tribo_biquad_f32_further_advance(const tribo_biquad_f32_params_t *params,
                                       tribo_biquad_f32_state_t        *state,
                                       float                            x,
                                       float                            correction);

/// The outputs of the cascade for the input `x`; returns the last one.
static inline float biquad_f32_output(const tribo_biquad_f32_params_t *params,
                                      tribo_biquad_f32_state_t        *state,
                                      float                            x,
                                      tribo_biquad_f32_outputs_t      *outputs)
{
    outputs->y[0] = biquad_f32_section_output(&params->section[0], &state->section[0], x);
    outputs->y[1] = biquad_f32_section_output(&params->section[1], &state->section[1], outputs->y[0]);
    return params->count > 2u ? tribo_biquad_f32_further_output(params, state, outputs->y[1]) : outputs->y[1];
}

/// The states of all sections, as if the input had been x + `correction`: it goes on through the direct feedthrough b0 of
/// each section to the outputs.
static inline void biquad_f32_advance(const tribo_biquad_f32_params_t  *params,
                                      tribo_biquad_f32_state_t         *state,
                                      float                             x,
                                      const tribo_biquad_f32_outputs_t *outputs,
                                      float                             correction)
{
    const float c0 = correction * params->section[0].b0;
    const float c1 = c0 * params->section[1].b0;
    const float y0 = outputs->y[0] + c0;
    const float y1 = outputs->y[1] + c1;
    biquad_f32_section_advance(&params->section[0], &state->section[0], x + correction, y0);
    biquad_f32_section_advance(&params->section[1], &state->section[1], y0, y1);
    if (params->count > 2u)
    {
        tribo_biquad_f32_further_advance(params, state, y1, c1);
    }
}

/// Rest, in place of a state that is corrupt, counted with the bad inputs.
static inline void biquad_f32_restart(tribo_biquad_f32_state_t *state)
{
    for (uint32_t i = 0; i < TRIBO_BIQUAD_SECTIONS_MAX; i++)
    {
        state->section[i] = (tribo_biquad_f32_section_state_t){0.0f, 0.0f, 0.0f};
    }
    count(&state->bad_inputs);
}

/// Jury's conditions in the delta operator: the roots of d^2 + c1 d + c2 are inside the unit circle, or one is at z = 1.
static inline bool biquad_f32_is_inside_or_at_1(float c1, float c2)
{
    return c2 >= 0.0f && c2 < c1 && (4.0f - 2.0f * c1) + c2 > 0.0f;
}

#endif
