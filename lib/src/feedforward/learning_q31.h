// Learning in fixed point; learning_f32.h has the equations.
//
//     quantity                              format    range           bounded by
//     Psi; k                                Q29       +-2; +-2        stops are within +-1; limited
//     V; S; W                               Q29       +-3; +-2; +-4   limited
//     (z - load)/L, sum of V Psi, epsilon, l Q26      +-32            limited
//     M, P                                  Q30       +-1             limited
//     q = M k                               Q27       +-6.4           |M| <= 1
//     S = q k                               Q24       0 to 45         likewise
//     rho                                   Q29       R to 65 R       R is at most FS/78
//     gain = delta/(rho + delta S)          Q31       0 to 1/2        delta <= R/2
//     gain epsilon                          Q29       +-0.72          the surprise: 2 sqrt(S)/(2 + S)
//     gain q                                Q29       +-4             limited
//
// Products are rounded towards zero, so mirrored forces give mirrored results. Without travel no bit changes.
// At most five divisions of 32 bits a tick. Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_LEARNING_Q31_H
#define TRIBO_FEEDFORWARD_LEARNING_Q31_H

#include "tribo/feedforward_q31.h"
#include "tribo/q31.h"

#include "../number/first_order_q31.h"
#include "bank_q31.h"
#include "constants.h"
#include "observer_q31.h"

#define LEARNING_Q31_ONE       (INT32_C(1) << 30) // of M and P
#define LEARNING_Q31_NOISE_MAX (UINT32_C(16) << 27)
#define LEARNING_Q31_Q26(x)    ((uint32_t)((double)(x) * 67108864.0 + 0.5))

/// The bits of numbers, added without carry.
static inline uint32_t learning_q31_fold(const int32_t *x, uint32_t count)
{
    uint32_t bits = 0;
#pragma GCC unroll 8
    for (uint32_t i = 0; i < count; i++)
    {
        bits ^= (uint32_t)x[i];
    }
    return bits;
}

/// Those that a stage changes.
static inline uint32_t learning_q31_fold_stage(const tribo_feedforward_weights_q31_t *x, uint32_t stage)
{
    switch (stage)
    {
    case 4:
        return learning_q31_fold(x->weight, 1u + TRIBO_FEEDFORWARD_STOPS);
    case 5:
        return (uint32_t)x->constant ^ (uint32_t)x->slope ^ (uint32_t)x->scale;
    case 6:
        return x->doubt ^ learning_q31_fold(x->use, 1u + TRIBO_FEEDFORWARD_STOPS);
    case 7:
        return learning_q31_fold(&x->covariance[0], 7);
    case 8:
        return learning_q31_fold(&x->covariance[7], 3) ^ learning_q31_fold(x->variance, TRIBO_FEEDFORWARD_STOPS);
    default:
        return 0;
    }
}

/// All that is learned: the seal of a memory that is not corrupt.
static inline uint32_t learning_q31_fold_all(const tribo_feedforward_weights_q31_t *x)
{
    uint32_t bits = 0;
#pragma GCC unroll 5
    for (uint32_t stage = 4; stage <= 8u; stage++)
    {
        bits ^= learning_q31_fold_stage(x, stage);
    }
    return bits;
}

/// What stages 0 to 3 leave to the others.
static inline uint32_t learning_q31_fold_sample(const tribo_feedforward_learning_q31_state_t *x, uint32_t stage)
{
    switch (stage)
    {
    case 0:
        return x->sample;
    case 1:
        return (uint32_t)x->error ^ x->weighing;
    case 2:
        return learning_q31_fold(x->gained, 4u);
    case 3:
        return learning_q31_fold(&x->gained[4], TRIBO_FEEDFORWARD_STOPS) ^ x->gain;
    default:
        return 0;
    }
}

/// A flipped bit in what is learned, or in the sample that it was learned from.
static inline bool learning_q31_corrupt(const tribo_feedforward_weights_q31_t        *learned,
                                        const tribo_feedforward_learning_q31_state_t *x)
{
    uint32_t bits = 0;
#pragma GCC unroll 4
    for (uint32_t stage = 0; stage <= 3u; stage++)
    {
        bits ^= learning_q31_fold_sample(x, stage);
    }
    return learning_q31_fold_all(learned) != learned->seal || (x->sample != 0u && bits != x->seal);
}

static inline void learning_q31_forget(tribo_feedforward_weights_q31_t *learned)
{
    *learned = (tribo_feedforward_weights_q31_t){
        .weight     = {BANK_Q31_ONE},
        .covariance = {[0] = LEARNING_Q31_ONE, [4] = LEARNING_Q31_ONE, [7] = LEARNING_Q31_ONE, [9] = LEARNING_Q31_ONE},
        .variance   = {LEARNING_Q31_ONE, LEARNING_Q31_ONE, LEARNING_Q31_ONE, LEARNING_Q31_ONE},
        .doubt      = UINT32_MAX,
        .use        = {BANK_Q31_ONE},
    };
    learned->seal = learning_q31_fold_all(learned);
}

static inline void learning_q31_start(tribo_feedforward_learning_q31_state_t *x, int32_t y)
{
    for (uint32_t j = 0; j <= TRIBO_FEEDFORWARD_STOPS; j++)
    {
        x->stop[j] = 0;
    }
    x->stage     = 0;
    x->side      = 0;
    x->hunts     = false;
    x->since     = 0;
    x->travelled = y;
    x->friction  = 0;
    x->load      = 0;
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
    const int64_t  ratio   = tribo_q31_shift((int64_t)product, 31u - L->shift);
    const int32_t  size    = (int32_t)(ratio < INT32_MAX ? ratio : INT32_MAX);
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
                                       const tribo_feedforward_observer_q31_state_t *measured,
                                       tribo_feedforward_learning_q31_state_t       *x,
                                       bool                                          allowed)
{
    const int32_t  moved  = difference_q31(measured->travelled, x->travelled);
    const uint32_t travel = tribo_q31_magnitude(moved);

    x->stop[0] = bank_q31_stop(x->stop[0], moved, params->measured_per_unit);
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        x->stop[j + 1u] = bank_q31_stop(x->stop[j + 1u], moved, params->stop_per_unit[j]);
    }
    const int32_t widest = x->stop[TRIBO_FEEDFORWARD_STOPS];
    const int8_t  side   = (int8_t)(tribo_q31_magnitude(widest) >= BANK_Q31_ONE ? bank_q31_sign(widest) : x->side);
    if (side != x->side)
    {
        x->hunts = x->since < params->quick_ticks / 2u;
        x->since = 0;
    }
    else if (x->since < params->quick_ticks / 2u)
    {
        x->since += FEEDFORWARD_STAGES;
    }
    const bool     hunts = x->hunts && x->since < params->quick_ticks / 2u;
    const uint32_t part  = travel < params->travel_max ? travel : params->travel_max;

    x->side      = side;
    x->jump      = difference_q31(measured->friction, x->friction);
    x->friction  = measured->friction;
    x->force     = measured->force;
    x->travelled = measured->travelled;
    x->sample    = allowed && !hunts && travel <= params->slip ? part : 0u;
}

static inline void learning_q31_regressor_of(const tribo_feedforward_q31_params_t   *params,
                                             const tribo_friction_q31_params_t      *friction,
                                             const tribo_feedforward_weights_q31_t  *learned,
                                             tribo_feedforward_learning_q31_state_t *x)
{
    const bank_q31_prior_t       prior = bank_q31_prior(friction, x->force);
    const learning_q31_divisor_t L     = learning_q31_divisor(prior.L);
    const uint32_t slope = tribo_q31_high(tribo_q31_magnitude(x->force), BANK_Q31_Q32(FEEDFORWARD_SLOPE_SD));
    int32_t *const k     = x->regressor;

    int64_t sum = tribo_q31_multiply(learned->weight[0], x->stop[0]); // Q58
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        const int32_t psi = difference_q31(x->stop[j + 1u], x->stop[j]);
        sum += tribo_q31_multiply(learned->weight[j + 1u], psi);
        k[4u + j] = part_of_q31(psi, BANK_Q31_Q32(FEEDFORWARD_STOP_SD));
    }
    k[0] = part_of_q31(x->stop[0], BANK_Q31_Q32(FEEDFORWARD_WEIGHT_SD));
    k[1] = learning_q31_regressor(params->constant_sd, &L);
    k[2] = learning_q31_regressor(slope, &L);
    k[3] = x->force < 0 ? -k[2] : k[2];

    const int32_t  jump   = bank_q31_times(x->jump, params->jump_lag, 16, INT32_MAX);
    const uint32_t sudden = tribo_q31_magnitude(learning_q31_over(jump, &L)); // Q26
    const uint32_t most   = LEARNING_Q31_Q26(FEEDFORWARD_JUMP_MAX);
    const uint32_t within = sudden < most ? sudden : most;
    const uint32_t square = tribo_q31_high(within, within); // Q20, to 64
    x->weighing           = params->weighing + (uint32_t)(tribo_q31_product(params->weighing, square) >> 20);

    const int32_t load    = bank_q31_load(learned, x->force);
    const int32_t net     = difference_q31(x->friction, bank_q31_both(&prior, load));
    uint32_t      ignored = 0;
    x->error              = tribo_q31_subtract(learning_q31_over(net, &L), learning_q31_high(sum), &ignored);
    x->load               = learning_q31_over(load, &L);
}

static inline void learning_q31_times(const int32_t M[10], const int32_t k[4], int32_t q[4])
{
    static const uint8_t row[4][4] = {{0, 1, 2, 3}, {1, 4, 5, 6}, {2, 5, 7, 8}, {3, 6, 8, 9}};
    for (uint32_t i = 0; i < 4u; i++)
    {
        int64_t sum = 0;
        for (uint32_t j = 0; j < 4u; j++)
        {
            sum += tribo_q31_multiply(M[row[i][j]], k[j]);
        }
        q[i] = learning_q31_high(sum);
    }
}

/// As the twin; Q31.
static inline uint32_t learning_q31_relative_variance(const tribo_feedforward_weights_q31_t        *learned,
                                                      const tribo_feedforward_learning_q31_state_t *x,
                                                      int32_t                                       sign)
{
    int32_t k[4] = {BANK_Q31_Q29(FEEDFORWARD_WEIGHT_SD)};
    int32_t q[4];
    int64_t now   = 0; // Q54
    int64_t prior = 0; // Q56
    for (uint32_t i = 1; i < 4u; i++)
    {
        k[i] = sign < 0 ? -x->regressor[i] : x->regressor[i];
    }
    learning_q31_times(learned->covariance, k, q);
    for (uint32_t i = 0; i < 4u; i++)
    {
        now += tribo_q31_multiply(q[i], k[i]) / 4;
        prior += tribo_q31_multiply(k[i], k[i]) / 4;
    }
    const uint32_t part =
        now > 0 ? (uint32_t)(now >> 30) : 0u; // Q24; GCOVR_EXCL_BR_LINE: rounding alone makes it negative
    const uint32_t all = (uint32_t)(prior >> 32);
    return part < all ? tribo_q31_ratio(part, all) : UINT32_C(1) << 31;
}

static inline void learning_q31_gain(const tribo_feedforward_weights_q31_t  *learned,
                                     tribo_feedforward_learning_q31_state_t *x)
{
    int64_t spread = 0;
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        x->gained[4u + j] = learning_q31_high(tribo_q31_multiply(learned->variance[j], x->regressor[4u + j]));
    }
    for (uint32_t i = 0; i < 4u + TRIBO_FEEDFORWARD_STOPS; i++)
    {
        spread += tribo_q31_multiply(x->gained[i], x->regressor[i]);
    }
    const uint32_t S      = spread > 0 ? (uint32_t)((uint64_t)spread >> 32) : 0u; // Q24
    const uint64_t wide   = tribo_q31_product(x->sample, S) >> 24;
    const uint32_t most   = UINT32_C(1) << 30;
    const uint32_t more   = wide < most ? (uint32_t)wide : most; // GCOVR_EXCL_BR_LINE: unit.feedforward_q31 goes beyond
    x->gain               = ratio_q31(x->sample, x->weighing + more);
    const uint32_t size   = tribo_q31_magnitude(x->error);
    const uint32_t square = tribo_q31_high(size, size); // Q20, to 1024
    const uint32_t usual =
        (uint32_t)FEEDFORWARD_SURPRISE * ((S >> 4) + LEARNING_Q31_Q26(FEEDFORWARD_MODEL_ERROR) / 64u); // Q20
    if (square > usual)
    {
        x->gain = tribo_q31_high(x->gain, 2u * ratio_q31(usual, square));
    }
}

/// Q27, to 16.
static inline uint32_t learning_q31_noise(const tribo_feedforward_q31_params_t *params,
                                          const tribo_feedforward_q31_state_t  *state)
{
    const uint64_t noise = tribo_q31_product(state->observer.noise, params->doubt_per_unit) >> 21;
    const uint32_t most  = LEARNING_Q31_NOISE_MAX;
    return noise < most ? (uint32_t)noise : most; // GCOVR_EXCL_BR_LINE: contract.learning_q31 goes beyond
}

/// 1 - (A_n/A)^2 in Q32, 0 up to A_n.
static inline uint32_t learning_q31_presliding(const int32_t *V, uint32_t noise)
{
    const uint32_t beside  = noise / 2u * (uint32_t)FEEDFORWARD_PRESLIDING_NOISE;
    const uint32_t least   = LEARNING_Q31_Q26(FEEDFORWARD_PRESLIDING_MIN) + beside;
    uint32_t       squares = 0; // Q26, to 16
    for (uint32_t j = 1; j <= TRIBO_FEEDFORWARD_STOPS; j++)
    {
        squares += tribo_q31_high(tribo_q31_magnitude(V[j]), tribo_q31_magnitude(V[j]));
    }
    if (squares <= least)
    {
        return 0;
    }
    const uint32_t ratio = 2u * ratio_q31(least, squares);
    return ~tribo_q31_high(ratio, ratio);
}

/// V^3/(V^2 + theta^2), within 1e-5: a division of 32 bits for what theta takes.
static inline int32_t learning_q31_shrunk(int32_t V)
{
    const uint32_t V2    = tribo_q31_high(tribo_q31_magnitude(V), tribo_q31_magnitude(V)); // Q26
    const uint32_t theta = LEARNING_Q31_Q26(FEEDFORWARD_SHRINK * FEEDFORWARD_SHRINK);
    const uint32_t taken = (theta << 10) / ((V2 + theta) / 256u + 1u); // Q18, below 1
    return part_of_q31(V, ~(taken << 14));
}

/// gain epsilon, Q29.
static inline int32_t learning_q31_step_of(const tribo_feedforward_learning_q31_state_t *x)
{
    return bank_q31_times(x->error, x->gain, 28, INT32_MAX);
}

/// A learned number of Q29 after `sd` (step q), within +-`most`. `sd` is Q31, `step` Q29, `q` Q27.
static inline int32_t learning_q31_moved(int32_t before, uint32_t sd, int32_t step, int32_t q, int32_t most)
{
    const int32_t by      = bank_q31_times(step, tribo_q31_magnitude(q), 27, INT32_MAX);
    const int32_t move    = bank_q31_times(q < 0 ? -by : by, sd, 31, INT32_MAX);
    uint32_t      ignored = 0;
    return limit_q31(tribo_q31_add(before, move, &ignored), -most, most);
}

static inline void learning_q31_weights(tribo_feedforward_weights_q31_t              *learned,
                                        const tribo_feedforward_learning_q31_state_t *x)
{
    const int32_t  step    = learning_q31_step_of(x);
    const uint32_t sd      = 4u * (uint32_t)BANK_Q31_Q29(FEEDFORWARD_WEIGHT_SD);
    const uint32_t stop_sd = 4u * (uint32_t)BANK_Q31_Q29(FEEDFORWARD_STOP_SD);
    const int32_t  least   = BANK_Q31_Q29(FEEDFORWARD_WEIGHT_MIN);
    int32_t *const V       = learned->weight;

    V[0] = learning_q31_moved(V[0], sd, step, x->gained[0], BANK_Q31_Q29(FEEDFORWARD_WEIGHT_MAX));
    V[0] = V[0] > least ? V[0] : least;
    for (uint32_t j = 1; j <= TRIBO_FEEDFORWARD_STOPS; j++)
    {
        V[j] = learning_q31_moved(V[j], stop_sd, step, x->gained[3u + j], BANK_Q31_Q29(FEEDFORWARD_STOP_MAX));
    }
}

static inline void learning_q31_load(const tribo_feedforward_q31_params_t *params, tribo_feedforward_q31_state_t *state)
{
    const tribo_feedforward_learning_q31_state_t *const x       = &state->learning;
    tribo_feedforward_weights_q31_t *const              learned = &state->learned;

    const int32_t  before = bank_q31_load(learned, state->reached);
    const int32_t  step   = learning_q31_step_of(x);
    const uint32_t sd     = 4u * (uint32_t)BANK_Q31_Q29(FEEDFORWARD_SLOPE_SD);
    const int32_t  slope  = BANK_Q31_Q29(FEEDFORWARD_SLOPE_MAX);
    const int32_t  most   = params->constant_max;

    learned->constant = learning_q31_moved(learned->constant, 4u * params->constant_sd, step, x->gained[1], most);
    learned->slope    = learning_q31_moved(learned->slope, sd, step, x->gained[2], slope);
    learned->scale    = learning_q31_moved(learned->scale, sd, step, x->gained[3], slope);
    state->offset     = sum_q31(state->offset, bank_q31_load(learned, state->reached) - before);
}

/// The bits of the numbers that a reversal changes.
static inline uint32_t learning_q31_fold_turned(const tribo_feedforward_weights_q31_t *x)
{
    return (uint32_t)x->weight[0] ^ (uint32_t)x->use[0] ^ learning_q31_fold_stage(x, 5);
}

static inline void learning_q31_turn(tribo_feedforward_weights_q31_t        *learned,
                                     tribo_feedforward_learning_q31_state_t *x)
{
    const int32_t  both_ways = BANK_Q31_Q29(2.0f * FEEDFORWARD_BOTH_WAYS); // as M, Q30
    const int32_t  one_way   = BANK_Q31_Q29(2.0f * FEEDFORWARD_ONE_WAY);
    const int32_t  lacks     = -bank_q31_product(x->load, x->stop[0]); // Q26
    const uint32_t above     = (uint32_t)(limit_q31(learned->covariance[0], both_ways, one_way) - both_ways);
    if (lacks <= 0 || above == 0u)
    {
        return;
    }
    const uint32_t part  = 2u * ratio_q31(above, (uint32_t)(one_way - both_ways)); // Q32
    const int32_t  lack  = part_of_q31(lacks, part);
    const int32_t  by    = bank_q31_times(lack, (uint32_t)BANK_Q31_Q29(FEEDFORWARD_LACK), 26, INT32_MAX);
    const int32_t  least = BANK_Q31_Q29(FEEDFORWARD_WEIGHT_MIN);
    const int32_t  V     = difference_q31(learned->weight[0], by);
    const int32_t  next  = V > least ? V : least;
    learned->seal ^= learning_q31_fold_turned(learned);
    learned->use[0]    = sum_q31(learned->use[0], difference_q31(next, learned->weight[0]));
    learned->weight[0] = next;
    learned->constant  = part_of_q31(learned->constant, ~part);
    learned->slope     = part_of_q31(learned->slope, ~part);
    learned->scale     = part_of_q31(learned->scale, ~part);
    x->load            = part_of_q31(x->load, ~part);
    learned->seal ^= learning_q31_fold_turned(learned);
}

/// 1 - min(1, travel per_unit), Q32; `per_unit` has 32 more bits than `shift`.
static inline uint32_t learning_q31_left(uint32_t travel, uint32_t per_unit, uint32_t shift)
{
    const uint64_t part = tribo_q31_product(travel, per_unit) >> shift;
    return ~(part < UINT32_MAX ? (uint32_t)part : UINT32_MAX); // GCOVR_EXCL_BR_LINE: unit.feedforward_q31 goes beyond
}

static inline void learning_q31_use(const tribo_feedforward_q31_params_t *params,
                                    tribo_feedforward_q31_state_t        *state,
                                    uint32_t                              level)
{
    const tribo_feedforward_learning_q31_state_t *const x       = &state->learning;
    tribo_feedforward_weights_q31_t *const              learned = &state->learned;

    const int32_t *const V    = learned->weight;
    int32_t *const       W    = learned->use;
    int32_t              last = 0;
    for (uint32_t j = TRIBO_FEEDFORWARD_STOPS; j > 0u; j--)
    {
        const int32_t S = part_of_q31(learning_q31_shrunk(V[j]), x->presliding);
        W[j]            = difference_q31(S, last);
        last            = S;
    }
    uint32_t       ignored = 0;
    const uint32_t k       = tribo_q31_high((uint32_t)x->regressor[1], BANK_Q31_Q32(FEEDFORWARD_SPARED)); // Q29
    const int32_t  most    = part_of_q31(V[0], BANK_Q31_Q32(FEEDFORWARD_SPARED_MAX));
    const int32_t  spared  = bank_q31_times((int32_t)k, learning_q31_noise(params, state), 27, (uint32_t)most);
    W[0]                   = tribo_q31_subtract(V[0] - spared, last, &ignored); // V_0 up to 3, S_1 down to -2
    learned->travel += x->sample;
    learned->doubt = tribo_q31_high(learned->doubt, learning_q31_left(x->sample, params->doubt_per_unit, 8));

    const int32_t f = bank_q31_friction(params, learned, level, bank_q31_partial(state), state->sigma);
    state->offset   = sum_q31(state->offset, f - state->f);
    state->f        = f;
}

/// x Q30 less gain q_i q_j, and forgetting by `part` towards `own`. `drop` is gain q_i, Q29; q_j is Q27.
static inline int32_t learning_q31_left_of(int32_t x, int32_t drop, int32_t q, int32_t own, uint32_t part)
{
    const int32_t after = difference_q31(x, (int32_t)tribo_q31_shift_to_zero(tribo_q31_multiply(drop, q), 26));
    return limit_q31(first_order_q31_step(after, own, part), own - LEARNING_Q31_ONE, LEARNING_Q31_ONE);
}

static inline void learning_q31_covariance(const tribo_feedforward_learning_q31_state_t *x,
                                           int32_t                                      *M,
                                           uint32_t                                      i,
                                           uint32_t                                      part)
{
    for (uint32_t end = i + 2u; i < end; i++)
    {
        const int32_t drop = bank_q31_times(x->gained[i], x->gain, 29, INT32_MAX);
        *M                 = learning_q31_left_of(*M, drop, x->gained[i], LEARNING_Q31_ONE, part);
        M++;
        for (uint32_t j = i + 1u; j < 4u; j++)
        {
            *M = learning_q31_left_of(*M, drop, x->gained[j], 0, part);
            M++;
        }
    }
}

static inline void learning_q31_variance(const tribo_feedforward_learning_q31_state_t *x, int32_t *P, uint32_t part)
{
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        const int32_t q    = x->gained[4u + j];
        const int32_t drop = bank_q31_times(q, x->gain, 29, INT32_MAX);
        P[j]               = learning_q31_left_of(P[j], drop, q, LEARNING_Q31_ONE, part);
    }
}

/// As the twin's.
static inline void learning_q31_work(const tribo_feedforward_q31_params_t *params,
                                     const tribo_friction_q31_params_t    *friction,
                                     tribo_feedforward_q31_state_t        *state,
                                     uint32_t                              stage,
                                     uint32_t                              level)
{
    tribo_feedforward_learning_q31_state_t *const x       = &state->learning;
    tribo_feedforward_weights_q31_t *const        learned = &state->learned;

    switch (stage)
    {
    case 1:
        learning_q31_regressor_of(params, friction, learned, x);
        break;
    case 2:
        learning_q31_times(learned->covariance, x->regressor, x->gained);
        break;
    case 3:
        learning_q31_gain(learned, x);
        break;
    case 4:
        learning_q31_weights(learned, x);
        state->hold.extra_margin =
            tribo_q31_high(state->hold.extra_margin, learning_q31_left(x->sample, params->margin_per_unit, 8));
        break;
    case 5:
        learning_q31_load(params, state);
        x->presliding = learning_q31_presliding(learned->weight, learning_q31_noise(params, state));
        break;
    case 6:
        learning_q31_use(params, state, level);
        break;
    case 7:
        learning_q31_covariance(x,
                                &learned->covariance[0],
                                0,
                                ~learning_q31_left(x->sample, params->forgetting_per_unit, 24));
        break;
    case 8: {
        const uint32_t part = ~learning_q31_left(x->sample, params->forgetting_per_unit, 24);
        learning_q31_covariance(x, &learned->covariance[7], 2, part);
        learning_q31_variance(x, learned->variance, part);
        break;
    }
    default:
        break;
    }
}

/// One tick: one stage; see the twin.
static inline void learning_q31_step(const tribo_feedforward_q31_params_t *params,
                                     const tribo_friction_q31_params_t    *friction,
                                     tribo_feedforward_q31_state_t        *state,
                                     uint32_t                              level,
                                     bool                                  allowed)
{
    tribo_feedforward_learning_q31_state_t *const x       = &state->learning;
    tribo_feedforward_weights_q31_t *const        learned = &state->learned;

    const uint32_t stage = x->stage;
    x->stage             = (uint8_t)(stage + 1u < FEEDFORWARD_STAGES ? stage + 1u : 0u);
    if (stage == 0u)
    {
        learning_q31_sample(params, &state->observer, x, allowed);
        x->seal = 0;
    }
    if (x->sample == 0u)
    {
        return;
    }
    learned->seal ^= learning_q31_fold_stage(learned, stage);
    learning_q31_work(params, friction, state, stage, level);
    x->seal ^= learning_q31_fold_sample(x, stage);
    learned->seal ^= learning_q31_fold_stage(learned, stage);
}

#endif
