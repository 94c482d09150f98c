#include "breakaway_learning_q31.h"

#include "tribo/feedforward_f32.h"
#include "tribo/feedforward_q31.h"

#include "../number/fixed_q31.h"
#include "../number/parameters.h"
#include "breakaway_learning_f32.h"

#include <stddef.h>

#define MEASURED_MAX (INT32_C(1) << 30)

static uint32_t good_prior(uint32_t prior)
{
    const uint32_t below = prior < BREAKAWAY_LEARNING_Q31_FULL ? prior : BREAKAWAY_LEARNING_Q31_FULL - 1u;
    return below > 0u ? below : 1u;
}

tribo_status_t tribo_breakaway_learning_q31_init(tribo_breakaway_learning_q31_params_t       *params,
                                                 const tribo_breakaway_learning_f32_config_t *design,
                                                 float                                        full_scale_n)
{
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_breakaway_learning_f32_params_t unused;
    const tribo_status_t                  status = tribo_breakaway_learning_f32_init(&unused, design);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!full_scale_ok(full_scale_n))
    {
        return TRIBO_ERR_FULL_SCALE;
    }
    if (!(design->scale_sd <= 1.0f))
    {
        return TRIBO_ERR_LEARNING_SCALE_SD;
    }
    if (!fits(design->offset_sd_n, full_scale_n))
    {
        return TRIBO_ERR_LEARNING_OFFSET_SD;
    }
    if (!within(design->weight_n / full_scale_n, FIXED_Q31_SMALLEST, 0.0625f))
    {
        return TRIBO_ERR_LEARNING_WEIGHT;
    }
    const float forgetting = design->forgetting_per_n * full_scale_n;
    if (!(forgetting < 32.0f))
    {
        return TRIBO_ERR_LEARNING_FORGETTING;
    }
    params->scale_sd          = fixed_unsigned(design->scale_sd, 32);
    params->offset_sd         = (uint32_t)units(design->offset_sd_n, full_scale_n);
    params->relative_variance = fixed(design->relative_variance, 30);
    params->correlation       = fixed(design->relative_variance * design->correlation, 30);
    params->correlation_faded = fixed_unsigned(design->correlation_faded, 32);
    params->distrust          = fixed_unsigned(1.0f - design->trust, 32);
    params->weight            = (uint32_t)fixed(design->weight_n / full_scale_n, 33);
    params->forgetting        = fixed_unsigned(forgetting, 27);
    params->scale_min         = fixed_unsigned(design->scale_min, 28);
    params->scale_max         = fixed_unsigned(design->scale_max, 28);
    return TRIBO_OK;
}

void tribo_breakaway_learning_q31_reset(const tribo_breakaway_learning_q31_params_t *params,
                                        tribo_breakaway_learning_q31_state_t        *state)
{
    const tribo_breakaway_learned_q31_t nothing = {.ss = params->relative_variance, .oo = params->relative_variance};
    *state                                      = (tribo_breakaway_learning_q31_state_t){
                                             .of     = {nothing, nothing},
                                             .shared = {params->correlation, 0, 0, params->correlation},
                                             .across = {.of = {nothing, nothing}, .shared = {params->correlation, 0, 0, params->correlation}}};
}

tribo_breakaway_learning_q31_signals_t tribo_breakaway_learning_q31_at(
    const tribo_breakaway_learning_q31_params_t *params,
    const tribo_breakaway_learning_q31_state_t  *state,
    uint32_t                                     direction,
    uint32_t                                     prior)
{
    const tribo_breakaway_learning_q31_place_t at = breakaway_learning_q31_place(params, good_prior(prior));
    return breakaway_learning_q31_at(params, state, direction & 1u, &at);
}

bool tribo_breakaway_learning_q31_is_at_bound(const tribo_breakaway_learning_q31_params_t *params,
                                              const tribo_breakaway_learning_q31_state_t  *state,
                                              uint32_t                                     direction,
                                              uint32_t                                     prior)
{
    const tribo_breakaway_learned_q31_t       *of = &state->of[direction & 1u];
    const tribo_breakaway_learning_q31_place_t at = breakaway_learning_q31_prior(params, good_prior(prior));

    const int32_t estimate = (int32_t)(at.l / 16u) + breakaway_learning_q31_deviation(of, &at);
    return estimate <= (int32_t)tribo_q31_high(at.l, params->scale_min) ||
           estimate >= (int32_t)tribo_q31_high(at.l, params->scale_max) ||
           tribo_q31_magnitude(of->scale) >= BREAKAWAY_LEARNING_Q31_T_MAX ||
           tribo_q31_magnitude(of->offset) >= BREAKAWAY_LEARNING_Q31_T_MAX;
}

static inline void exchange(int32_t *a, int32_t *b)
{
    const int32_t was = *a;
    *a                = *b;
    *b                = was;
}

// Field by field: copies of whole structs would take more stack than a tick has.
static inline void exchange_learned(tribo_breakaway_learned_q31_t *a, tribo_breakaway_learned_q31_t *b)
{
    exchange(&a->scale, &b->scale);
    exchange(&a->offset, &b->offset);
    exchange(&a->ss, &b->ss);
    exchange(&a->so, &b->so);
    exchange(&a->oo, &b->oo);
}

static inline void exchange_travel(uint64_t *a, uint64_t *b)
{
    const uint64_t was = *a;
    *a                 = *b;
    *b                 = was;
}

void tribo_breakaway_learning_q31_change_side(tribo_breakaway_learning_q31_state_t *state)
{
    tribo_breakaway_across_q31_t *const across = &state->across;

    const uint32_t near = (UINT32_C(1) << 28) / 10u;
    const bool     same = state->travel[0] > 0u && state->travel[1] > 0u &&
                      (tribo_q31_magnitude(state->of[0].scale - across->of[0].scale) < near ||
                       tribo_q31_magnitude(state->of[1].scale - across->of[1].scale) < near);
    const int32_t apart = same ? 0 : BREAKAWAY_LEARNING_Q31_ONE / 4;
    // Halved: rounding may lift a variance above 1.
    if (same || state->of[0].ss / 2 + state->of[1].ss / 2 + apart < across->of[0].ss / 2 + across->of[1].ss / 2)
    {
        // Keep a copy on both sides. No loops: they would become calls of memmove.
        across->of[0]     = state->of[0];
        across->of[1]     = state->of[1];
        across->shared[0] = state->shared[0];
        across->shared[1] = state->shared[1];
        across->shared[2] = state->shared[2];
        across->shared[3] = state->shared[3];
        state->of[0].ss += apart;
        state->of[1].ss += apart;
    }
    else
    {
        exchange_learned(&state->of[0], &across->of[0]);
        exchange_learned(&state->of[1], &across->of[1]);
        exchange(&state->shared[0], &across->shared[0]);
        exchange(&state->shared[1], &across->shared[1]);
        exchange(&state->shared[2], &across->shared[2]);
        exchange(&state->shared[3], &across->shared[3]);
    }
    exchange_travel(&state->travel[0], &across->travel[0]);
    exchange_travel(&state->travel[1], &across->travel[1]);
}

void tribo_breakaway_learning_q31_slide_ends(const tribo_breakaway_learning_q31_params_t *params,
                                             tribo_breakaway_learning_q31_state_t        *state,
                                             uint32_t                                     direction,
                                             uint32_t                                     prior)
{
    uint8_t *const slides = &state->bound_slides[direction & 1u];
    if (state->slid == 0)
    {
        return; // as little known as before
    }
    state->slid = 0;
    if (!tribo_breakaway_learning_q31_is_at_bound(params, state, direction, prior))
    {
        *slides = 0;
        return;
    }
    *slides = (uint8_t)(*slides + (*slides < UINT8_MAX));
    if (*slides >= TRIBO_BREAKAWAY_BOUND_SLIDES)
    {
        state->stays_at_bound[direction & 1u] = 1;
    }
}

void tribo_breakaway_learning_q31_restore(tribo_breakaway_learning_q31_state_t *state)
{
    for (uint32_t d = 0; d < 2u; d++)
    {
        state->bound_slides[d]   = 0;
        state->stays_at_bound[d] = 0;
    }
}
