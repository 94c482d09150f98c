// What is known of breakaway, and one measurement, for inputs that are known to be good. Formats: see the header's table.
// With travel 0 a measurement changes nothing, to the last bit, so that it can be taken in every tick.

#ifndef TRIBO_BREAKAWAY_LEARNING_Q31_STEP_H
#define TRIBO_BREAKAWAY_LEARNING_Q31_STEP_H

#include "tribo/breakaway_learning_q31.h"

#include "first_order_q31.h"
#include "limit_q31.h"

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

/// A place without its variance, which a measurement there does not need.
static inline tribo_breakaway_learning_q31_place_t breakaway_learning_q31_prior(
    const tribo_breakaway_learning_q31_params_t *params,
    uint32_t                                     prior)
{
    const uint32_t shift  = tribo_q31_leading_zeros(prior) - 3u;
    const uint32_t l      = prior << shift << 2;
    const uint32_t offset = params->spread_offset < prior ? params->spread_offset : prior;
    return (tribo_breakaway_learning_q31_place_t){.l     = l,
                                                  .a0    = (int32_t)tribo_q31_high(l, params->spread_scale),
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

/// a q, Q28. A covariance that rounding has made indefinite must not make it negative.
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

    // Variance left over variance at first.
    const int32_t  q_s   = high_sum_q31(of->ss, at->a0, of->so, at->a1);
    const int32_t  q_o   = high_sum_q31(of->so, at->a0, of->oo, at->a1);
    const uint32_t left  = breakaway_learning_q31_variance(at, q_s, q_o);
    const uint32_t below = left < at->variance ? left : at->variance - 1u;
    const uint32_t doubt = tribo_q31_high(below << at->lift, at->inverse);

    const int32_t  estimate = (int32_t)(at->l / 16u) + breakaway_learning_q31_deviation(of, at);
    const int32_t  least    = (int32_t)tribo_q31_high(at->l, params->scale_min);
    const int32_t  most     = (int32_t)tribo_q31_high(at->l, params->scale_max);
    const uint32_t whole    = ((uint32_t)limit_q31(estimate, least, most) << 2) >> at->shift;
    const uint32_t L        = whole < BREAKAWAY_LEARNING_Q31_FULL ? whole : BREAKAWAY_LEARNING_Q31_FULL;
    const uint32_t discount = tribo_q31_high(params->distrust, 2u * doubt); // Q32
    return (
        tribo_breakaway_learning_q31_signals_t){.L = L, .doubt = doubt, .weighted = L - tribo_q31_high(L, discount)};
}

static inline void breakaway_learning_q31_move(int32_t *t, int32_t pull, int32_t q)
{
    *t = limit_q31(*t + 2 * high_q31(pull, q), -BREAKAWAY_LEARNING_Q31_T_MAX, BREAKAWAY_LEARNING_Q31_T_MAX);
}

/// What is left of a covariance after a measurement, gain q[i] q[j] less, and after fading.
static inline int32_t breakaway_learning_q31_left(int32_t P, int32_t gain_q, int32_t q, int32_t fade)
{
    const int32_t left = difference_q31(P, 16 * high_q31(gain_q, q));
    return left - high_q31(left, fade);
}

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
