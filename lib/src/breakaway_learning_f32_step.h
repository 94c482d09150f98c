// What is known of breakaway, and one measurement, for inputs that are known to be good. With travel 0 a measurement changes
// nothing, to the last bit, so that it can be taken in every tick.

#ifndef TRIBO_BREAKAWAY_LEARNING_F32_STEP_H
#define TRIBO_BREAKAWAY_LEARNING_F32_STEP_H

#include "tribo/breakaway_learning_f32.h"

#include "limit_f32.h"

static inline float breakaway_learning_f32_estimate(const tribo_breakaway_learned_f32_t *of, float prior)
{
    return prior + (of->scale * prior + of->offset_n);
}

static inline tribo_breakaway_learning_f32_place_t breakaway_learning_f32_place(
    const tribo_breakaway_learning_f32_params_t *params,
    float                                        prior)
{
    return (tribo_breakaway_learning_f32_place_t){.prior_n = prior,
                                                  .variance =
                                                      prior * prior * params->scale_variance + params->offset_variance};
}

static inline tribo_breakaway_learning_f32_signals_t breakaway_learning_f32_at(
    const tribo_breakaway_learning_f32_params_t *params,
    const tribo_breakaway_learning_f32_state_t  *state,
    uint32_t                                     direction,
    const tribo_breakaway_learning_f32_place_t  *at)
{
    const tribo_breakaway_learned_f32_t *of    = &state->of[direction];
    const float                          prior = at->prior_n;

    // Variance left over variance at first.
    const float left  = prior * (prior * of->ss + 2.0f * of->so) + of->oo;
    const float doubt = left / at->variance;

    const float L =
        limit_f32(breakaway_learning_f32_estimate(of, prior), params->scale_min * prior, params->scale_max * prior);
    return (tribo_breakaway_learning_f32_signals_t){.L_n        = L,
                                                    .doubt      = doubt,
                                                    .weighted_n = L - params->distrust * doubt * L};
}

static inline void breakaway_learning_f32_step(const tribo_breakaway_learning_f32_params_t *params,
                                               tribo_breakaway_learning_f32_state_t        *state,
                                               uint32_t                                     direction,
                                               float                                        travel,
                                               float                                        prior,
                                               float                                        measured)
{
    tribo_breakaway_learned_f32_t *const own   = &state->of[direction];
    tribo_breakaway_learned_f32_t *const other = &state->of[1u - direction];

    // Own scale and offset with the other's.
    float *const ss = &state->shared[0];
    float *const so = &state->shared[1u + direction];
    float *const os = &state->shared[2u - direction];
    float *const oo = &state->shared[3];

    // q = P a, for the own states and the other's. Its a q is 0 or more but for rounding, which is far below weight prior^2.
    const float q_s      = own->ss * prior + own->so;
    const float q_o      = own->so * prior + own->oo;
    const float p_s      = *ss * prior + *os;
    const float p_o      = *so * prior + *oo;
    const float variance = q_s * prior + q_o;
    const float gain     = travel / (params->weight_n * (prior * prior) + travel * variance);
    const float pull     = gain * (measured - breakaway_learning_f32_estimate(own, prior));

    own->scale      = bound_f32(own->scale + pull * q_s, params->scale_most);
    own->offset_n   = bound_f32(own->offset_n + pull * q_o, params->offset_most_n);
    other->scale    = bound_f32(other->scale + pull * p_s, params->scale_most);
    other->offset_n = bound_f32(other->offset_n + pull * p_o, params->offset_most_n);

    const float fading = params->forgetting_per_n * travel;
    const float fade   = fading < 1.0f ? fading : 1.0f;
    const float keep   = 1.0f - fade;
    const float scale  = fade * params->scale_variance;
    const float offset = fade * params->offset_variance;
    const float g_s    = gain * q_s;
    const float g_o    = gain * q_o;
    const float h_s    = gain * p_s;
    const float h_o    = gain * p_o;

    own->ss   = keep * (own->ss - g_s * q_s) + scale;
    own->so   = keep * (own->so - g_s * q_o);
    own->oo   = keep * (own->oo - g_o * q_o) + offset;
    other->ss = keep * (other->ss - h_s * p_s) + scale;
    other->so = keep * (other->so - h_s * p_o);
    other->oo = keep * (other->oo - h_o * p_o) + offset;
    *ss       = keep * (*ss - g_s * p_s) + fade * params->scale_shared;
    *so       = keep * (*so - g_s * p_o);
    *os       = keep * (*os - g_o * p_s);
    *oo       = keep * (*oo - g_o * p_o) + fade * params->offset_shared;

    state->travel_n[direction] += travel;
}

#endif
