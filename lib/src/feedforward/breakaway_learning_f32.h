// Learns breakaway L(F) in each direction while the arm slides, single precision: a Kalman filter over newton travelled.
//
//     L(F) = (1 + scale) prior(F) + offset
//
// The four states are scale and offset of each direction, initially 0 with the config's standard deviations; P is their
// covariance. Learning in one direction moves the other by their correlation. For a measurement z at F after `travel` newton
// of slide, with a = (prior, 1) for that direction and q = P a:
//
//     gain = travel/(weight prior^2 + travel a q)      x += gain q (z - L(F))      P -= gain q q'
//     fade = min(1, forgetting travel)                 P += fade (P_prior - P)
//
// so nothing moves while the arm stands. The relative variance, a'P a over its initial value, from 1 to 0, is the remaining
// fraction of the prior's variance at F. A feed-forward uses the weighted (1 - (1 - trust) relative variance) L.
// One division a step and one an estimate; no loops. Not synchronized: one state, one tick.
// Source: Kalman, "A new approach to linear filtering and prediction problems", 1960.

#ifndef TRIBO_FEEDFORWARD_BREAKAWAY_LEARNING_F32_H
#define TRIBO_FEEDFORWARD_BREAKAWAY_LEARNING_F32_H

#include "tribo/feedforward_f32.h"
#include "tribo/status.h"

#include "../number/ieee_f32.h"

/// The defaults of the design, for forces about 1 N.
tribo_breakaway_learning_f32_config_t tribo_breakaway_learning_f32_default(void);

/// Returns TRIBO_OK, TRIBO_ERR_NULL or that of a row of TRIBO_LEARNING_PARAMETERS. Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_breakaway_learning_f32_init(tribo_breakaway_learning_f32_params_t       *params,
                                                 const tribo_breakaway_learning_f32_config_t *config);

/// Nothing learned. Call it before the first step: a zeroed state has no relative variance.
void tribo_breakaway_learning_f32_reset(const tribo_breakaway_learning_f32_params_t *params,
                                        tribo_breakaway_learning_f32_state_t        *state);

/// Learned L in `direction` where the prior is `prior_n`, 1e-6 to 2e7 N; a bad prior counts as 1e-6 N.
tribo_breakaway_learning_f32_signals_t tribo_breakaway_learning_f32_at(
    const tribo_breakaway_learning_f32_params_t *params,
    const tribo_breakaway_learning_f32_state_t  *state,
    uint32_t                                     direction,
    float                                        prior_n);

/// True when learning in `direction` is at a bound: a state at three standard deviations, or L at scale_min or scale_max of
/// `prior_n`. The prior is then too wrong for the params, or the measurement is not friction. Not for every tick.
bool tribo_breakaway_learning_f32_is_at_bound(const tribo_breakaway_learning_f32_params_t *params,
                                              const tribo_breakaway_learning_f32_state_t  *state,
                                              uint32_t                                     direction,
                                              float                                        prior_n);

/// Changes to the other sign of F. Each sign learns apart, but the old sign's values replace the new one's in two cases. Either
/// it has slid in both directions and the signs agree on the scale of one direction within a tenth of its standard deviation
/// (a wrong scale of the command makes both directions differ, and differently). Or its variance is lower, even with half a
/// standard deviation added for a difference. The counts of slide_ends belong to both signs. Not for every tick.
void tribo_breakaway_learning_f32_change_side(const tribo_breakaway_learning_f32_params_t *params,
                                              tribo_breakaway_learning_f32_state_t        *state);

/// Call at the end of a slide in `direction`, at a force where the prior is `prior_n`. Counts consecutive slides with learning
/// that ended at a bound, and latches at TRIBO_BREAKAWAY_BOUND_SLIDES. A single slide may end there while a wrong first
/// measurement is being corrected; staying there means that the model does not describe the friction.
void tribo_breakaway_learning_f32_slide_ends(const tribo_breakaway_learning_f32_params_t *params,
                                             tribo_breakaway_learning_f32_state_t        *state,
                                             uint32_t                                     direction,
                                             float                                        prior_n);

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

    // Remaining over initial variance.
    const float left              = prior * (prior * of->ss + 2.0f * of->so) + of->oo;
    const float relative_variance = left / at->variance;

    const float L =
        limit_f32(breakaway_learning_f32_estimate(of, prior), params->scale_min * prior, params->scale_max * prior);
    return (tribo_breakaway_learning_f32_signals_t){.L_n               = L,
                                                    .relative_variance = relative_variance,
                                                    .weighted_n        = L - params->distrust * relative_variance * L};
}

/// One measurement: in `direction` breakaway is `measured` where the prior is `prior`, from `travel` of slide. With travel 0
/// no bit changes, so it may run in every tick.
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

    // q = P a, for the own states and the other's. Its a q is 0 or more, except for rounding far below weight prior^2.
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
