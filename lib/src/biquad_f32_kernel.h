// What a tick of a cascade is made of, inline, for a caller that has checked its input.

#ifndef TRIBO_BIQUAD_F32_KERNEL_H
#define TRIBO_BIQUAD_F32_KERNEL_H

#include "tribo/biquad_f32.h"

#include "exact_f32.h"
#include "run_f32.h"

#include <stdbool.h>

#define BIQUAD_F32_OUTPUT_MAX 1.0e15f // far beyond any sane gain: past it a state is lost

/// The state at rest again, counted with the bad inputs. Inline, as a call would cost every tick its registers.
static inline void biquad_f32_start_again(tribo_biquad_f32_state_t *state)
{
    for (uint32_t i = 0; i < TRIBO_BIQUAD_SECTIONS_MAX; i++)
    {
        state->section[i] = (tribo_biquad_f32_section_state_t){0.0f, 0.0f, 0.0f};
    }
    count(&state->bad_inputs);
}

/// Jury's conditions in the delta operator: the roots of d^2 + c1 d + c2 are inside the unit circle, or one is at z = 1.
static inline bool biquad_f32_inside_or_at_1(float c1, float c2)
{
    return c2 >= 0.0f && c2 < c1 && (4.0f - 2.0f * c1) + c2 > 0.0f;
}

/// The section's state after a tick. By value: what is written late need not be read twice.
static inline tribo_biquad_f32_section_state_t biquad_f32_section_advance(const tribo_biquad_f32_section_t *section,
                                                                          tribo_biquad_f32_section_state_t  state,
                                                                          float                             in,
                                                                          float                             out)
{
    const float change = (section->b2 * in - section->a2 * out) + state.w2_carry;
    const float w2     = state.w2 + change;
    return (tribo_biquad_f32_section_state_t){.w1 = state.w1 + ((section->b1 * in - section->a1 * out) + state.w2),
                                              .w2 = w2,
                                              .w2_carry = change - (w2 - state.w2)};
}

/// Two sections, the usual case: their input and outputs.
typedef struct
{
    float x, y0, y1;
} biquad_f32_pair_t;

static inline biquad_f32_pair_t biquad_f32_pair_output(const tribo_biquad_f32_params_t *params,
                                                       const tribo_biquad_f32_state_t  *state,
                                                       float                            x)
{
    const float y0 = params->section[0].b0 * x + state->section[0].w1;
    return (biquad_f32_pair_t){.x = x, .y0 = y0, .y1 = params->section[1].b0 * y0 + state->section[1].w1};
}

/// `pair` as if its input had been `correction` larger.
static inline void biquad_f32_pair_correct(const tribo_biquad_f32_params_t *params,
                                           biquad_f32_pair_t               *pair,
                                           float                            correction)
{
    const float c0 = correction * params->section[0].b0;
    pair->x += correction;
    pair->y0 += c0;
    pair->y1 += c0 * params->section[1].b0;
}

static inline void biquad_f32_pair_advance(const tribo_biquad_f32_params_t *params,
                                           tribo_biquad_f32_state_t        *state,
                                           const biquad_f32_pair_t         *pair)
{
    const tribo_biquad_f32_section_t      *at    = params->section;
    const run_f32_pair_t                   was   = run_f32_pair(state);
    const tribo_biquad_f32_section_t       first = run_f32_first(&at);
    const tribo_biquad_f32_section_state_t next_0 =
        biquad_f32_section_advance(&first, was.section[0], pair->x, pair->y0);
    const tribo_biquad_f32_section_t       last = run_f32_last(&at);
    const tribo_biquad_f32_section_state_t next_1 =
        biquad_f32_section_advance(&last, was.section[1], pair->y0, pair->y1);
    run_f32_keep_pair(state, (run_f32_pair_t){{next_0, next_1}});
}

#endif
