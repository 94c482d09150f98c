#include "breakaway_learning_f32.h"

#include "tribo/feedforward_f32.h"

#include "../number/parameters.h"

#include <stddef.h>

#define PRIOR_MIN_N 1.0e-6f
#define PRIOR_MAX_N 2.0e7f // above offset + slope |F| of any friction params

tribo_breakaway_learning_f32_config_t tribo_breakaway_learning_f32_default(void)
{
    const tribo_breakaway_learning_f32_config_t standard = {TRIBO_LEARNING_PARAMETERS(PARAMETERS_DEFAULT)};
    return standard;
}

tribo_status_t tribo_breakaway_learning_f32_init(tribo_breakaway_learning_f32_params_t       *params,
                                                 const tribo_breakaway_learning_f32_config_t *config)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    const tribo_status_t status = PARAMETERS_CHECK(tribo_learning_parameters, config);
    if (status != TRIBO_OK)
    {
        return status;
    }
    params->scale_most        = 3.0f * config->scale_sd;
    params->offset_most_n     = 3.0f * config->offset_sd_n;
    params->scale_variance    = config->scale_sd * config->scale_sd;
    params->offset_variance   = config->offset_sd_n * config->offset_sd_n;
    params->scale_shared      = config->correlation_faded * params->scale_variance;
    params->offset_shared     = config->correlation_faded * params->offset_variance;
    params->correlation       = config->correlation;
    params->relative_variance = config->relative_variance;
    params->distrust          = 1.0f - config->trust;
    params->weight_n          = config->weight_n;
    params->forgetting_per_n  = config->forgetting_per_n;
    params->scale_min         = config->scale_min;
    params->scale_max         = config->scale_max;
    return TRIBO_OK;
}

void tribo_breakaway_learning_f32_reset(const tribo_breakaway_learning_f32_params_t *params,
                                        tribo_breakaway_learning_f32_state_t        *state)
{
    const float                         scale    = params->relative_variance * params->scale_variance;
    const float                         offset   = params->relative_variance * params->offset_variance;
    const tribo_breakaway_learned_f32_t nothing  = {.ss = scale, .oo = offset};
    const float                         shared[] = {params->correlation * scale, params->correlation * offset};
    *state                                       = (tribo_breakaway_learning_f32_state_t){
                                              .of     = {nothing, nothing},
                                              .shared = {shared[0], 0.0f, 0.0f, shared[1]},
                                              .across = {.of = {nothing, nothing}, .shared = {shared[0], 0.0f, 0.0f, shared[1]}}};
}

tribo_breakaway_learning_f32_signals_t tribo_breakaway_learning_f32_at(
    const tribo_breakaway_learning_f32_params_t *params,
    const tribo_breakaway_learning_f32_state_t  *state,
    uint32_t                                     direction,
    float                                        prior_n)
{
    const float prior                             = within(prior_n, PRIOR_MIN_N, PRIOR_MAX_N) ? prior_n : PRIOR_MIN_N;
    const tribo_breakaway_learning_f32_place_t at = breakaway_learning_f32_place(params, prior);
    return breakaway_learning_f32_at(params, state, direction & 1u, &at);
}

bool tribo_breakaway_learning_f32_is_at_bound(const tribo_breakaway_learning_f32_params_t *params,
                                              const tribo_breakaway_learning_f32_state_t  *state,
                                              uint32_t                                     direction,
                                              float                                        prior_n)
{
    const tribo_breakaway_learned_f32_t *of = &state->of[direction & 1u];
    const float                          L  = breakaway_learning_f32_estimate(of, prior_n);
    return !(L > params->scale_min * prior_n && L < params->scale_max * prior_n &&
             magnitude(of->scale) < params->scale_most && magnitude(of->offset_n) < params->offset_most_n);
}

static inline void exchange(float *a, float *b)
{
    const float was = *a;
    *a              = *b;
    *b              = was;
}

// Field by field: copies of whole structs would take more stack than a tick has.
static inline void exchange_learned(tribo_breakaway_learned_f32_t *a, tribo_breakaway_learned_f32_t *b)
{
    exchange(&a->scale, &b->scale);
    exchange(&a->offset_n, &b->offset_n);
    exchange(&a->ss, &b->ss);
    exchange(&a->so, &b->so);
    exchange(&a->oo, &b->oo);
}

void tribo_breakaway_learning_f32_change_side(const tribo_breakaway_learning_f32_params_t *params,
                                              tribo_breakaway_learning_f32_state_t        *state)
{
    tribo_breakaway_across_f32_t *const across = &state->across;

    const float near = params->scale_most / 30.0f; // a tenth of the standard deviation
    const bool  same = state->travel_n[0] > 0.0f && state->travel_n[1] > 0.0f &&
                      (magnitude(state->of[0].scale - across->of[0].scale) < near ||
                       magnitude(state->of[1].scale - across->of[1].scale) < near);
    const float apart = same ? 0.0f : 0.25f * params->scale_variance;
    if (same || state->of[0].ss + state->of[1].ss + 2.0f * apart < across->of[0].ss + across->of[1].ss)
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
    exchange(&state->travel_n[0], &across->travel_n[0]);
    exchange(&state->travel_n[1], &across->travel_n[1]);
}

void tribo_breakaway_learning_f32_slide_ends(const tribo_breakaway_learning_f32_params_t *params,
                                             tribo_breakaway_learning_f32_state_t        *state,
                                             uint32_t                                     direction,
                                             float                                        prior_n)
{
    uint8_t *const slides = &state->bound_slides[direction & 1u];
    if (state->slid == 0)
    {
        return; // as little known as before
    }
    state->slid = 0;
    if (!tribo_breakaway_learning_f32_is_at_bound(params, state, direction, prior_n))
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

void tribo_breakaway_learning_f32_restore(tribo_breakaway_learning_f32_state_t *state)
{
    for (uint32_t d = 0; d < 2u; d++)
    {
        state->bound_slides[d]   = 0;
        state->stays_at_bound[d] = 0;
    }
}
