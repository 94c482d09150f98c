// Learning in fixed point; learning_f32.h has the equations.
//
//     quantity                              format    range           bounded by
//     Psi; k                                Q29       +-2; +-2        stops are within +-1; limited
//     V; S; W                               Q29       +-3, +-5        limited
//     (z - load)/L, sum of V Psi, epsilon   Q26       +-32            limited
//     M, P                                  Q30       +-1             limited
//     q = M k                               Q27       +-6.4           |M| <= 1
//     S = q k                               Q24       0 to 45         likewise
//     rho                                   Q29       R to 65 R       R is at most FS/78
//     gain = delta/(rho + delta S)          Q31       0 to 1/2        delta <= R/2
//     gain epsilon                          Q29       +-4             limited
//     gain q                                Q29       +-4             limited
//
// Products are rounded towards zero, so mirrored forces give mirrored results. Without travel no bit changes.
// At most four divisions of 32 bits a tick. Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_LEARNING_Q31_H
#define TRIBO_FEEDFORWARD_LEARNING_Q31_H

#include "tribo/feedforward_q31.h"
#include "tribo/q31.h"

#include "../number/first_order_q31.h"
#include "bank_q31.h"
#include "constants.h"
#include "observer_q31.h"

#define LEARNING_Q31_ONE    (INT32_C(1) << 30) // of M and P
#define LEARNING_Q31_Q26(x) ((uint32_t)((double)(x) * 67108864.0 + 0.5))

static inline void learning_q31_forget(tribo_feedforward_weights_q31_t *learned)
{
    *learned = (tribo_feedforward_weights_q31_t){
        .weight     = {BANK_Q31_ONE},
        .covariance = {[0] = LEARNING_Q31_ONE, [4] = LEARNING_Q31_ONE, [7] = LEARNING_Q31_ONE, [9] = LEARNING_Q31_ONE},
        .variance   = {LEARNING_Q31_ONE, LEARNING_Q31_ONE, LEARNING_Q31_ONE, LEARNING_Q31_ONE},
        .doubt      = UINT32_MAX,
        .use        = {BANK_Q31_ONE},
    };
}

static inline bool learning_q31_beyond(int32_t x, int32_t most)
{
    return tribo_q31_magnitude(x) > (uint32_t)most;
}

static inline bool learning_q31_corrupt(const tribo_feedforward_q31_params_t  *params,
                                        const tribo_feedforward_weights_q31_t *x)
{
    bool bad = x->weight[0] < BANK_Q31_Q29(FEEDFORWARD_WEIGHT_MIN) ||
               x->weight[0] > BANK_Q31_Q29(FEEDFORWARD_WEIGHT_MAX) ||
               learning_q31_beyond(x->constant, params->constant_max) ||
               learning_q31_beyond(x->slope, BANK_Q31_Q29(FEEDFORWARD_SLOPE_MAX)) ||
               learning_q31_beyond(x->scale, BANK_Q31_Q29(FEEDFORWARD_SLOPE_MAX));
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        bad = bad || learning_q31_beyond(x->weight[j + 1u], BANK_Q31_Q29(FEEDFORWARD_STOP_MAX));
    }
    return bad;
}

/// 2^63/(L 2^shift): L of Q29 without its leading zeros.
typedef struct
{
    uint32_t inverse, shift;
} learning_q31_divisor_t;

static inline learning_q31_divisor_t learning_q31_divisor(uint32_t L)
{
    const uint32_t whole = L | 1u; // never 0
    const uint32_t shift = tribo_q31_leading_zeros(whole);
    return (learning_q31_divisor_t){.inverse = tribo_q31_inverse(whole << shift), .shift = shift};
}

/// x/L in Q26, within +-32.
static inline int32_t learning_q31_over(int32_t x, const learning_q31_divisor_t *L)
{
    const uint64_t product = tribo_q31_product(tribo_q31_magnitude(x), L->inverse) >> 6; // 2^57 x/(L 2^shift)
    const uint64_t ratio   = product >> (31u - L->shift);
    const int32_t  size    = (int32_t)(ratio < (uint64_t)INT32_MAX ? (uint32_t)ratio : (uint32_t)INT32_MAX);
    return x < 0 ? -size : size;
}

/// A regressor of the load, x/L in Q29, at most FEEDFORWARD_LOAD_MAX.
static inline int32_t learning_q31_regressor(uint32_t x, const learning_q31_divisor_t *L)
{
    const int32_t ratio = learning_q31_over((int32_t)x, L);
    const int32_t most  = BANK_Q31_Q29(FEEDFORWARD_LOAD_MAX) / 8;
    return 8 * (ratio < most ? ratio : most);
}

/// The upper word of x, rounded towards zero.
static inline int32_t learning_q31_high(int64_t x)
{
    return (int32_t)(tribo_q31_shift_to_zero(x, 31) / 2);
}

static inline void learning_q31_sample(const tribo_feedforward_q31_params_t         *params,
                                       const tribo_friction_q31_params_t            *friction,
                                       const tribo_feedforward_observer_q31_state_t *observer,
                                       const tribo_feedforward_weights_q31_t        *learned,
                                       tribo_feedforward_learning_q31_state_t       *x,
                                       const observer_q31_signals_t                 *measured)
{
    const int32_t                force = observer->force;
    const bank_q31_prior_t       prior = bank_q31_prior(friction, force);
    const learning_q31_divisor_t L     = learning_q31_divisor(prior.L);
    const uint32_t               sd    = BANK_Q31_Q32(FEEDFORWARD_WEIGHT_SD);
    const uint32_t               slope = tribo_q31_high(tribo_q31_magnitude(force), BANK_Q31_Q32(FEEDFORWARD_SLOPE_SD));

    int64_t sum  = 0; // Q58
    int32_t last = 0;
    int32_t psi[1u + TRIBO_FEEDFORWARD_STOPS];
    for (uint32_t j = 0; j <= TRIBO_FEEDFORWARD_STOPS; j++)
    {
        psi[j] = observer->stop[j] - last;
        last   = observer->stop[j];
        sum += tribo_q31_multiply(learned->weight[j], psi[j]);
    }
    x->regressor[0] = part_of_q31(psi[0], sd);
    x->regressor[1] = learning_q31_regressor(params->constant_sd, &L);
    x->regressor[2] = learning_q31_regressor(slope, &L);
    x->regressor[3] = force < 0 ? -x->regressor[2] : x->regressor[2];
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        x->regressor[4u + j] = part_of_q31(psi[j + 1u], BANK_Q31_Q32(FEEDFORWARD_STOP_SD));
    }
    const int32_t  jump   = bank_q31_times(measured->jump, params->jump_lag, 16, INT32_MAX);
    const uint32_t sudden = tribo_q31_magnitude(learning_q31_over(jump, &L)); // Q26
    const uint32_t most   = LEARNING_Q31_Q26(FEEDFORWARD_JUMP_MAX);
    const uint32_t within = sudden < most ? sudden : most;
    const uint32_t square = tribo_q31_high(within, within); // Q20, to 64
    x->weighing           = params->weighing + (uint32_t)(tribo_q31_product(params->weighing, square) >> 20);

    const int32_t net     = difference_q31(measured->friction, bank_q31_load(learned, &prior, force));
    const int32_t z       = learning_q31_over(net, &L);
    uint32_t      ignored = 0;
    x->error              = tribo_q31_subtract(z, learning_q31_high(sum), &ignored);
    x->sample             = x->travel;
    x->travel             = 0;
}

static inline void learning_q31_gain(const tribo_feedforward_weights_q31_t  *learned,
                                     tribo_feedforward_learning_q31_state_t *x)
{
    static const uint8_t row[4][4] = {{0, 1, 2, 3}, {1, 4, 5, 6}, {2, 5, 7, 8}, {3, 6, 8, 9}};

    const int32_t *const k      = x->regressor;
    int32_t *const       q      = x->gained;
    int64_t              spread = 0;

    for (uint32_t i = 0; i < 4u; i++)
    {
        int64_t sum = 0;
        for (uint32_t j = 0; j < 4u; j++)
        {
            sum += tribo_q31_multiply(learned->covariance[row[i][j]], k[j]);
        }
        q[i] = learning_q31_high(sum);
    }
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        q[4u + j] = learning_q31_high(tribo_q31_multiply(learned->variance[j], k[4u + j]));
    }
    for (uint32_t i = 0; i < 4u + TRIBO_FEEDFORWARD_STOPS; i++)
    {
        spread += tribo_q31_multiply(q[i], k[i]);
    }
    const uint32_t S    = spread > 0 ? (uint32_t)((uint64_t)spread >> 32) : 0u; // Q24
    const uint64_t wide = tribo_q31_product(x->sample, S) >> 24;
    const uint32_t most = UINT32_C(1) << 30;
    x->gain             = ratio_q31(x->sample, x->weighing + (wide < most ? (uint32_t)wide : most));
    // A surprise beyond two standard deviations is a push, not friction.
    const uint32_t size   = tribo_q31_magnitude(x->error);
    const uint32_t square = tribo_q31_high(size, size); // Q20, to 1024
    const uint32_t usual =
        (uint32_t)FEEDFORWARD_SURPRISE * ((S >> 4) + LEARNING_Q31_Q26(FEEDFORWARD_MODEL_ERROR) / 64u); // Q20
    if (square > usual)
    {
        x->gain = tribo_q31_high(x->gain, 2u * ratio_q31(usual, square));
    }
}

/// 1 - (A_0/A)^2 in Q32 for squares A in Q26, 0 up to A_0.
static inline uint32_t learning_q31_presliding(uint32_t squares)
{
    const uint32_t least = LEARNING_Q31_Q26(FEEDFORWARD_PRESLIDING_MIN);
    if (squares <= least)
    {
        return 0;
    }
    const uint32_t ratio = 2u * ratio_q31(least, squares);
    return ~tribo_q31_high(ratio, ratio);
}

/// V^3/(V^2 + theta^2).
static inline int32_t learning_q31_shrunk(int32_t V)
{
    const uint32_t V2    = tribo_q31_high(tribo_q31_magnitude(V), tribo_q31_magnitude(V)); // Q26
    const uint32_t theta = (uint32_t)BANK_Q31_Q29(FEEDFORWARD_SHRINK * FEEDFORWARD_SHRINK) / 8u;
    return part_of_q31(V, 2u * ratio_q31(V2, V2 + theta));
}

/// A learned number of Q29 after `sd` (step q), within its bounds. `step` is Q29, `q` Q27.
static inline int32_t learning_q31_moved(int32_t before, uint32_t sd, int32_t step, int32_t q, int32_t min, int32_t max)
{
    const int32_t by      = bank_q31_times(step, tribo_q31_magnitude(q), 27, INT32_MAX);
    const int32_t move    = bank_q31_times(q < 0 ? -by : by, sd, 31, INT32_MAX);
    uint32_t      ignored = 0;
    return limit_q31(tribo_q31_add(before, move, &ignored), min, max);
}

static inline void learning_q31_weights(const tribo_feedforward_q31_params_t         *params,
                                        tribo_feedforward_weights_q31_t              *learned,
                                        const tribo_feedforward_learning_q31_state_t *x)
{
    const int32_t  step  = bank_q31_times(x->error, x->gain, 28, INT32_MAX); // Q29
    const uint32_t sd    = (uint32_t)BANK_Q31_Q29(FEEDFORWARD_WEIGHT_SD) * 4u;
    const int32_t  slope = BANK_Q31_Q29(FEEDFORWARD_SLOPE_MAX);
    const int32_t  most  = params->constant_max;
    int32_t *const V     = learned->weight;
    int32_t *const W     = learned->use;

    learned->constant =
        learning_q31_moved(learned->constant, 4u * params->constant_sd, step, x->gained[1], -most, most);
    learned->slope = learning_q31_moved(learned->slope,
                                        (uint32_t)BANK_Q31_Q29(FEEDFORWARD_SLOPE_SD) * 4u,
                                        step,
                                        x->gained[2],
                                        -slope,
                                        slope);
    learned->scale = learning_q31_moved(learned->scale,
                                        (uint32_t)BANK_Q31_Q29(FEEDFORWARD_SLOPE_SD) * 4u,
                                        step,
                                        x->gained[3],
                                        -slope,
                                        slope);
    V[0]           = learning_q31_moved(V[0],
                              sd,
                              step,
                              x->gained[0],
                              BANK_Q31_Q29(FEEDFORWARD_WEIGHT_MIN),
                              BANK_Q31_Q29(FEEDFORWARD_WEIGHT_MAX));

    uint32_t squares = 0; // Q26, to 16
    for (uint32_t j = 1; j <= TRIBO_FEEDFORWARD_STOPS; j++)
    {
        const int32_t  widest  = BANK_Q31_Q29(FEEDFORWARD_STOP_MAX);
        const uint32_t stop_sd = (uint32_t)BANK_Q31_Q29(FEEDFORWARD_STOP_SD) * 4u;

        V[j] = learning_q31_moved(V[j], stop_sd, step, x->gained[3u + j], -widest, widest);
        squares += tribo_q31_high(tribo_q31_magnitude(V[j]), tribo_q31_magnitude(V[j]));
    }
    const uint32_t part = learning_q31_presliding(squares);
    int32_t        last = 0;
    for (uint32_t j = TRIBO_FEEDFORWARD_STOPS; j > 0u; j--)
    {
        const int32_t S = part_of_q31(learning_q31_shrunk(V[j]), part);
        W[j]            = difference_q31(S, last);
        last            = S;
    }
    W[0] = difference_q31(V[0], last);
}

/// 1 - min(1, travel per_unit), Q32; `per_unit` has 32 more bits than `shift`.
static inline uint32_t learning_q31_left(uint32_t travel, uint32_t per_unit, uint32_t shift)
{
    const uint64_t part = tribo_q31_product(travel, per_unit) >> shift;
    return ~(part < UINT32_MAX ? (uint32_t)part : UINT32_MAX);
}

/// gain q_i q_j, Q30.
static inline int32_t learning_q31_drop(const tribo_feedforward_learning_q31_state_t *x, uint32_t i, uint32_t j)
{
    const int32_t gained = bank_q31_times(x->gained[i], x->gain, 29, INT32_MAX); // Q29
    const int32_t size   = bank_q31_times(gained, tribo_q31_magnitude(x->gained[j]), 26, INT32_MAX);
    return x->gained[j] < 0 ? -size : size;
}

static inline void learning_q31_covariance(const tribo_feedforward_q31_params_t         *params,
                                           tribo_feedforward_weights_q31_t              *learned,
                                           const tribo_feedforward_learning_q31_state_t *x)
{
    const uint32_t part = ~learning_q31_left(x->sample, params->forgetting_per_unit, 24);
    int32_t *const M    = learned->covariance;

    for (uint32_t i = 0, at = 0; i < 4u; i++)
    {
        for (uint32_t j = i; j < 4u; j++, at++)
        {
            const int32_t own   = i == j ? LEARNING_Q31_ONE : 0;
            const int32_t after = difference_q31(M[at], learning_q31_drop(x, i, j));
            M[at] = limit_q31(first_order_q31_step(after, own, part), own - LEARNING_Q31_ONE, LEARNING_Q31_ONE);
        }
    }
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        int32_t *const P     = &learned->variance[j];
        const int32_t  after = difference_q31(*P, learning_q31_drop(x, 4u + j, 4u + j));
        *P                   = limit_q31(first_order_q31_step(after, LEARNING_Q31_ONE, part), 0, LEARNING_Q31_ONE);
    }
}

/// One tick; see the twin.
static inline bool learning_q31_step(const tribo_feedforward_q31_params_t *params,
                                     const tribo_friction_q31_params_t    *friction,
                                     tribo_feedforward_q31_state_t        *state,
                                     const observer_q31_signals_t         *measured,
                                     bool                                  learns)
{
    tribo_feedforward_learning_q31_state_t *const x       = &state->learning;
    tribo_feedforward_weights_q31_t *const        learned = &state->learned;

    const uint32_t left   = params->travel_max;
    const uint32_t before = x->travel < left ? x->travel : left;
    const uint32_t moved  = learns ? tribo_q31_magnitude(measured->travel) : 0u;
    x->travel             = moved < left - before ? before + moved : left;
    switch (x->stage)
    {
    case 1:
        learning_q31_gain(learned, x);
        x->stage = 2;
        return false;
    case 2:
        learning_q31_weights(params, learned, x);
        learned->travel += x->sample;
        learned->doubt = tribo_q31_high(learned->doubt, learning_q31_left(x->sample, params->doubt_per_unit, 8));
        state->hold.extra_margin =
            tribo_q31_high(state->hold.extra_margin, learning_q31_left(x->sample, params->margin_per_unit, 8));
        x->stage = 3;
        return true;
    case 3:
        learning_q31_covariance(params, learned, x);
        x->stage = 0;
        return false;
    default:
        x->stage = 0;
        if (learns && x->travel > 0u)
        {
            learning_q31_sample(params, friction, &state->observer, learned, x, measured);
            x->stage = 1;
        }
        return false;
    }
}

#endif
