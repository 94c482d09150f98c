// A cascade of sections, with the scales of its nodes, and a controller, by itself in Q31: the two halves of a tick.

#ifndef TESTS_SUPPORT_CASCADE_Q31_H
#define TESTS_SUPPORT_CASCADE_Q31_H

#include "controller/anti_windup_q31.h"
#include "controller/biquad_f32.h"
#include "controller/biquad_q31.h"
#include "controller/headroom_q31.h"
#include "number/fixed_q31.h"

#include <stddef.h>

/// For inputs up to full scale. `headroom` may be null. Writes nothing unless TRIBO_OK.
static inline tribo_status_t cascade_q31_init(tribo_biquad_q31_params_t        *params,
                                              const tribo_biquad_f32_section_t *sections,
                                              uint32_t                          count,
                                              tribo_headroom_q31_t             *headroom)
{
    tribo_biquad_q31_params_t     made   = {.count = 0};
    tribo_controller_f32_params_t f32    = {.anti_windup = 0.0f};
    tribo_status_t                status = tribo_biquad_f32_init(&f32.cascade, sections, count, NULL);
    if (status == TRIBO_OK)
    {
        status = tribo_headroom_q31_quantize(&made, &f32, NULL, NULL, FIXED_Q31_FULL, 0.0f, headroom);
    }
    if (status == TRIBO_OK)
    {
        *params = made;
    }
    return status;
}

/// The first half: y in Q31, unsaturated (up to 2^scale of full scale).
static inline int64_t cascade_q31_output(const tribo_biquad_q31_params_t *params,
                                         tribo_biquad_q31_state_t        *state,
                                         int32_t                          x,
                                         tribo_biquad_q31_outputs_t      *outputs)
{
    return tribo_q31_lift(biquad_q31_output(params, state, x, outputs), params->output_scale);
}

static inline int32_t cascade_q31_step(const tribo_biquad_q31_params_t *params,
                                       tribo_biquad_q31_state_t        *state,
                                       int32_t                          x)
{
    tribo_biquad_q31_outputs_t outputs;
    const int64_t              y = cascade_q31_output(params, state, x, &outputs);
    biquad_q31_advance(params, state, &outputs, 0);
    return tribo_q31_saturate(y, &state->saturated);
}

/// A controller by itself: u for the error `e`.
static inline int32_t controller_q31_step(const tribo_controller_q31_params_t *params,
                                          tribo_controller_q31_state_t        *state,
                                          int32_t                              e,
                                          int32_t                              term,
                                          tribo_controller_q31_signals_t      *signals)
{
    tribo_biquad_q31_outputs_t outputs;

    const int32_t y = biquad_q31_output(&params->cascade, &state->cascade, e, &outputs);
    return controller_q31_apply(params, state, e, y, term, &outputs, signals);
}

#endif
