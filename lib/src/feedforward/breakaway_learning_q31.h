// Learns breakaway L(F) in each direction while the arm slides, in fixed point; breakaway_learning_f32.h has the
// equations.
//
// The states are in units of their prior standard deviation, t = scale/scale_sd and offset/offset_sd, so that t and their
// covariance P have a known range. For each direction and force all forces are shifted left until the prior l is between
// 1/2 and 1. Results then have a known range, too, without a division:
//
//     a = (scale_sd l, offset_sd)      L = l + a t      q = P a
//
//     quantity                                  format   range        room     bounded by
//     l; a                                      Q31      1; 1, 1      x 1      offset_sd counts up to l
//     t                                         Q28      +-3          x 2.6    limited
//     P                                         Q30      +-1          x 2
//     q                                         Q29      +-2          x 2
//     a q; l^2                                  Q28; Q30 0 to 4; 1    x 4      unsigned
//     gain = travel/(weight l^2 + travel a q)   Q29      0 to 4       x 1      limited
//     gain q                                    Q29      +-2          x 2      q^2 <= a q <= 1/gain
//     gain q[i] q[j]                            Q26      +-1          x 32
//     z - L                                     Q27      +-11         x 1.4    z counts up to 4 l
//     gain (z - L)                              Q24      +-44         x 2.9    then limited to +-1, Q30
//     L                                         Q27      -5 to 7      x 2.2    then limited, scale_min l to scale_max l
//     fade                                      Q32      0 to 1/4     x 2      forgetting and travel are limited
//     weight, travel, their sum                 1/16 units, 2^29, 2^24, 2^30
//
// Forces and travel are in one unit, 0 to 2^29 of them, travel up to 2^20. Products are rounded down, in the same order for
// both directions: mirrored forces give the same bits. Without travel no bit changes.
// One division of 32 bits a step and one an estimate; no loops. Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_BREAKAWAY_LEARNING_Q31_H
#define TRIBO_FEEDFORWARD_BREAKAWAY_LEARNING_Q31_H

#include "tribo/feedforward_f32.h"
#include "tribo/feedforward_q31.h"
#include "tribo/q31.h"

#include "../number/first_order_q31.h"
#include "breakaway_learning_f32.h"

/// Converts `design` in N to `params` in units of 2^-29 full scales. Returns TRIBO_OK, TRIBO_ERR_NULL,
/// TRIBO_ERR_FULL_SCALE or a status of tribo_breakaway_learning_f32_init. Writes nothing unless TRIBO_OK.
tribo_status_t tribo_breakaway_learning_q31_init(tribo_breakaway_learning_q31_params_t       *params,
                                                 const tribo_breakaway_learning_f32_config_t *design,
                                                 float                                        full_scale_n);

/// Nothing learned. Call it before the first step: a zeroed state has no relative variance.
void tribo_breakaway_learning_q31_reset(const tribo_breakaway_learning_q31_params_t *params,
                                        tribo_breakaway_learning_q31_state_t        *state);

/// Learned L in `direction` where the prior is `prior`, limited to 1 to 2^29 - 1 units.
tribo_breakaway_learning_q31_signals_t tribo_breakaway_learning_q31_at(
    const tribo_breakaway_learning_q31_params_t *params,
    const tribo_breakaway_learning_q31_state_t  *state,
    uint32_t                                     direction,
    uint32_t                                     prior);

/// True when learning in `direction` is at a bound; see the twin.
bool tribo_breakaway_learning_q31_is_at_bound(const tribo_breakaway_learning_q31_params_t *params,
                                              const tribo_breakaway_learning_q31_state_t  *state,
                                              uint32_t                                     direction,
                                              uint32_t                                     prior);

/// Changes to the other sign of F; see the twin.
void tribo_breakaway_learning_q31_change_side(tribo_breakaway_learning_q31_state_t *state);

/// Call at the end of a slide in `direction`, at a force where the prior is `prior`; see the twin.
void tribo_breakaway_learning_q31_slide_ends(const tribo_breakaway_learning_q31_params_t *params,
                                             tribo_breakaway_learning_q31_state_t        *state,
                                             uint32_t                                     direction,
                                             uint32_t                                     prior);

#define BREAKAWAY_LEARNING_Q31_T_MAX      (3 * (INT32_C(1) << 28))
#define BREAKAWAY_LEARNING_Q31_ONE        (INT32_C(1) << 30) // of P
#define BREAKAWAY_LEARNING_Q31_PULL_MAX   (INT32_C(1) << 24)
#define BREAKAWAY_LEARNING_Q31_FULL       (UINT32_C(1) << 29)
#define BREAKAWAY_LEARNING_Q31_TRAVEL_MAX (UINT32_C(1) << 20)

/// The upper word of a b.
static inline int32_t high_q31(int32_t a, int32_t b)
{
    return (int32_t)(uint32_t)((uint64_t)tribo_q31_multiply(a, b) >> 32);
}

/// The upper word of a b + c d.
static inline int32_t high_sum_q31(int32_t a, int32_t b, int32_t c, int32_t d)
{
    return (int32_t)(uint32_t)((uint64_t)(tribo_q31_multiply(a, b) + tribo_q31_multiply(c, d)) >> 32);
}

/// A place without its variance, which a measurement does not need.
static inline tribo_breakaway_learning_q31_place_t breakaway_learning_q31_prior(
    const tribo_breakaway_learning_q31_params_t *params,
    uint32_t                                     prior)
{
    const uint32_t shift  = tribo_q31_leading_zeros(prior) - 3u;
    const uint32_t l      = prior << shift << 2;
    const uint32_t offset = params->offset_sd < prior ? params->offset_sd : prior;
    return (tribo_breakaway_learning_q31_place_t){.l     = l,
                                                  .a0    = (int32_t)tribo_q31_high(l, params->scale_sd),
                                                  .a1    = (int32_t)(offset << shift << 2),
                                                  .shift = (uint8_t)shift};
}

static inline tribo_breakaway_learning_q31_place_t breakaway_learning_q31_place(
    const tribo_breakaway_learning_q31_params_t *params,
    uint32_t                                     prior)
{
    tribo_breakaway_learning_q31_place_t at = breakaway_learning_q31_prior(params, prior);
    at.variance                             = (uint32_t)high_sum_q31(at.a0, at.a0, at.a1, at.a1) >> 2 | 1u; // not 0
    at.lift                                 = (uint8_t)tribo_q31_leading_zeros(at.variance);
    at.inverse                              = tribo_q31_inverse(at.variance << at.lift);
    return at;
}

/// a q, Q28, kept from becoming negative where rounding has made the covariance indefinite.
static inline uint32_t breakaway_learning_q31_variance(const tribo_breakaway_learning_q31_place_t *at,
                                                       int32_t                                     q_s,
                                                       int32_t                                     q_o)
{
    const int32_t sum = high_sum_q31(q_s, at->a0, q_o, at->a1);
    return sum > 0 ? (uint32_t)sum : 0u;
}

/// a t, Q27.
static inline int32_t breakaway_learning_q31_deviation(const tribo_breakaway_learned_q31_t        *of,
                                                       const tribo_breakaway_learning_q31_place_t *at)
{
    return high_sum_q31(of->scale, at->a0, of->offset, at->a1);
}

static inline tribo_breakaway_learning_q31_signals_t breakaway_learning_q31_at(
    const tribo_breakaway_learning_q31_params_t *params,
    const tribo_breakaway_learning_q31_state_t  *state,
    uint32_t                                     direction,
    const tribo_breakaway_learning_q31_place_t  *at)
{
    const tribo_breakaway_learned_q31_t *of = &state->of[direction];

    // Remaining over initial variance.
    const int32_t  q_s               = high_sum_q31(of->ss, at->a0, of->so, at->a1);
    const int32_t  q_o               = high_sum_q31(of->so, at->a0, of->oo, at->a1);
    const uint32_t left              = breakaway_learning_q31_variance(at, q_s, q_o);
    const uint32_t below             = left < at->variance ? left : at->variance - 1u;
    const uint32_t relative_variance = tribo_q31_high(below << at->lift, at->inverse);

    const int32_t  estimate = (int32_t)(at->l / 16u) + breakaway_learning_q31_deviation(of, at);
    const int32_t  least    = (int32_t)tribo_q31_high(at->l, params->scale_min);
    const int32_t  most     = (int32_t)tribo_q31_high(at->l, params->scale_max);
    const uint32_t whole    = ((uint32_t)limit_q31(estimate, least, most) << 2) >> at->shift;
    const uint32_t L        = whole < BREAKAWAY_LEARNING_Q31_FULL ? whole : BREAKAWAY_LEARNING_Q31_FULL;
    const uint32_t discount = tribo_q31_high(params->distrust, 2u * relative_variance); // Q32
    return (tribo_breakaway_learning_q31_signals_t){.L                 = L,
                                                    .relative_variance = relative_variance,
                                                    .weighted          = L - tribo_q31_high(L, discount)};
}

static inline void breakaway_learning_q31_move(int32_t *t, int32_t pull, int32_t q)
{
    *t = limit_q31(*t + 2 * high_q31(pull, q), -BREAKAWAY_LEARNING_Q31_T_MAX, BREAKAWAY_LEARNING_Q31_T_MAX);
}

/// A covariance after a measurement, less gain q[i] q[j], and after fading.
static inline int32_t breakaway_learning_q31_left(int32_t P, int32_t gain_q, int32_t q, int32_t fade)
{
    const int32_t left = difference_q31(P, 16 * high_q31(gain_q, q));
    return left - high_q31(left, fade);
}

/// One measurement: in `direction` breakaway is `measured`, within +-2^30, where the prior is `prior`, 1 to 2^29 - 1, from
/// `travel` of slide, up to 2^20. With travel 0 no bit changes.
static inline void breakaway_learning_q31_step(const tribo_breakaway_learning_q31_params_t *params,
                                               tribo_breakaway_learning_q31_state_t        *state,
                                               uint32_t                                     direction,
                                               uint32_t                                     travel,
                                               uint32_t                                     prior,
                                               int32_t                                      measured)
{
    const tribo_breakaway_learning_q31_place_t at    = breakaway_learning_q31_prior(params, prior);
    tribo_breakaway_learned_q31_t *const       own   = &state->of[direction];
    tribo_breakaway_learned_q31_t *const       other = &state->of[1u - direction];

    // Own scale and offset with the other's.
    int32_t *const ss = &state->shared[0];
    int32_t *const so = &state->shared[1u + direction];
    int32_t *const os = &state->shared[2u - direction];
    int32_t *const oo = &state->shared[3];

    // q = P a, for the own states and the other's.
    const int32_t q_s = high_sum_q31(own->ss, at.a0, own->so, at.a1);
    const int32_t q_o = high_sum_q31(own->so, at.a0, own->oo, at.a1);
    const int32_t p_s = high_sum_q31(*ss, at.a0, *os, at.a1);
    const int32_t p_o = high_sum_q31(*so, at.a0, *oo, at.a1);

    const uint32_t variance = breakaway_learning_q31_variance(&at, q_s, q_o);
    const uint32_t square   = tribo_q31_high(at.l, at.l);
    const uint32_t known    = tribo_q31_high(4u * params->weight, square) + tribo_q31_high(256u * travel, variance);
    const int32_t  gain     = (int32_t)ratio_q31(16u * travel, 4u * known);

    const int32_t most  = (int32_t)(4u * prior - 1u);
    const int32_t z     = limit_q31(measured, -most, most) * (int32_t)(UINT32_C(1) << at.shift) / 4; // Q27
    const int32_t error = z - (int32_t)(at.l / 16u) - breakaway_learning_q31_deviation(own, &at);
    const int32_t pull =
        64 * limit_q31(high_q31(gain, error), -BREAKAWAY_LEARNING_Q31_PULL_MAX, BREAKAWAY_LEARNING_Q31_PULL_MAX);
    breakaway_learning_q31_move(&own->scale, pull, q_s);
    breakaway_learning_q31_move(&own->offset, pull, q_o);
    breakaway_learning_q31_move(&other->scale, pull, p_s);
    breakaway_learning_q31_move(&other->offset, pull, p_o);

    const int32_t fade   = (int32_t)(tribo_q31_product(travel, params->forgetting) >> 24); // Q32
    const int32_t back   = fade / 4;                                                       // Q30
    const int32_t shared = (int32_t)tribo_q31_high((uint32_t)back, params->correlation_faded);
    const int32_t g_s    = 8 * high_q31(gain, q_s);
    const int32_t g_o    = 8 * high_q31(gain, q_o);
    const int32_t h_s    = 8 * high_q31(gain, p_s);
    const int32_t h_o    = 8 * high_q31(gain, p_o);

    own->ss   = breakaway_learning_q31_left(own->ss, g_s, q_s, fade) + back;
    own->so   = breakaway_learning_q31_left(own->so, g_s, q_o, fade);
    own->oo   = breakaway_learning_q31_left(own->oo, g_o, q_o, fade) + back;
    other->ss = breakaway_learning_q31_left(other->ss, h_s, p_s, fade) + back;
    other->so = breakaway_learning_q31_left(other->so, h_s, p_o, fade);
    other->oo = breakaway_learning_q31_left(other->oo, h_o, p_o, fade) + back;
    *ss       = breakaway_learning_q31_left(*ss, g_s, p_s, fade) + shared;
    *so       = breakaway_learning_q31_left(*so, g_s, p_o, fade);
    *os       = breakaway_learning_q31_left(*os, g_o, p_s, fade);
    *oo       = breakaway_learning_q31_left(*oo, g_o, p_o, fade) + shared;

    state->travel[direction] += travel;
}

#endif
