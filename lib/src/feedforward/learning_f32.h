// Learning of friction over the prior, single precision: step 11 of docs/feedforward.md.
//
// Weighted least squares in which the travelled distance weighs, as friction is a matter of distance:
//
//     z/L = V0 Psi0 + ... + V4 Psi4 + (D + c0 + c1 |yf| + c2 yf)/L        Psi_j: stop j less stop j-1, on the measured force
//
// with the full covariance M of V0 and c0 to c2, and a variance P each for V1 to V4, all over the prior's. A sample is worked off in
// stages, one a tick. No loops but the stops'; at most five divisions a tick. Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_LEARNING_F32_H
#define TRIBO_FEEDFORWARD_LEARNING_F32_H

#include "tribo/feedforward_f32.h"

#include "../number/ieee_f32.h"
#include "bank_f32.h"
#include "constants.h"
#include "observer_f32.h"

/// The bits of numbers, added without carry.
static inline uint32_t learning_f32_fold(const float *x, uint32_t count)
{
    uint32_t bits = 0;
#pragma GCC unroll 8
    for (uint32_t i = 0; i < count; i++)
    {
        bits ^= bits_f32(x[i]);
    }
    return bits;
}

/// Those that a stage changes.
static inline uint32_t learning_f32_fold_stage(const tribo_feedforward_weights_f32_t *x, uint32_t stage)
{
    switch (stage)
    {
    case 4:
        return learning_f32_fold(x->weight, 1u + TRIBO_FEEDFORWARD_STOPS);
    case 5:
        return bits_f32(x->constant_n) ^ bits_f32(x->slope) ^ bits_f32(x->scale);
    case 6:
        return bits_f32(x->doubt) ^ learning_f32_fold(x->use, 1u + TRIBO_FEEDFORWARD_STOPS);
    case 7:
        return learning_f32_fold(&x->covariance[0], 7);
    case 8:
        return learning_f32_fold(&x->covariance[7], 3) ^ learning_f32_fold(x->variance, TRIBO_FEEDFORWARD_STOPS);
    default:
        return 0;
    }
}

/// All that is learned: the seal of a memory that is not corrupt.
static inline uint32_t learning_f32_fold_all(const tribo_feedforward_weights_f32_t *x)
{
    uint32_t bits = 0;
#pragma GCC unroll 5
    for (uint32_t stage = 4; stage <= 8u; stage++)
    {
        bits ^= learning_f32_fold_stage(x, stage);
    }
    return bits;
}

/// What stages 0 to 3 leave to the others.
static inline uint32_t learning_f32_fold_sample(const tribo_feedforward_learning_f32_state_t *x, uint32_t stage)
{
    switch (stage)
    {
    case 0:
        return bits_f32(x->sample_n);
    case 1:
        return bits_f32(x->error) ^ bits_f32(x->weighing_n);
    case 2:
        return learning_f32_fold(x->gained, 4u + TRIBO_FEEDFORWARD_STOPS);
    case 3:
        return bits_f32(x->gain);
    default:
        return 0;
    }
}

/// A flipped bit in what is learned, or in the sample that it was learned from.
static inline bool learning_f32_corrupt(const tribo_feedforward_weights_f32_t        *learned,
                                        const tribo_feedforward_learning_f32_state_t *x)
{
    uint32_t bits = 0;
#pragma GCC unroll 4
    for (uint32_t stage = 0; stage <= 3u; stage++)
    {
        bits ^= learning_f32_fold_sample(x, stage);
    }
    return learning_f32_fold_all(learned) != learned->seal || (x->sample_n != 0.0f && bits != x->seal);
}

/// Nothing learned: friction is the prior's, without presliding.
static inline void learning_f32_forget(tribo_feedforward_weights_f32_t *learned)
{
    *learned = (tribo_feedforward_weights_f32_t){
        .weight     = {1.0f},
        .covariance = {[0] = 1.0f, [4] = 1.0f, [7] = 1.0f, [9] = 1.0f},
        .variance   = {1.0f, 1.0f, 1.0f, 1.0f},
        .doubt      = 1.0f,
        .use        = {1.0f},
    };
    learned->seal = learning_f32_fold_all(learned);
}

/// No sample yet, at the measured force y.
static inline void learning_f32_start(tribo_feedforward_learning_f32_state_t *x, float y)
{
    for (uint32_t j = 0; j <= TRIBO_FEEDFORWARD_STOPS; j++)
    {
        x->stop[j] = 0.0f;
    }
    x->stage       = 0;
    x->side        = 0;
    x->hunts       = false;
    x->since       = 0;
    x->travelled_n = y;
    x->friction_n  = 0.0f;
    x->load        = 0.0f;
}

/// Stage 0: the measured force moves the stops on. `allowed`: its friction may be learned.
static inline void learning_f32_sample(const tribo_feedforward_f32_params_t   *params,
                                       tribo_feedforward_observer_f32_state_t *measured,
                                       tribo_feedforward_learning_f32_state_t *x,
                                       bool                                    allowed)
{
    if (exceeds(measured->friction_n, FEEDFORWARD_FORCE_MAX_N))
    {
        observer_f32_start(measured, measured->y_n[0]);
    }
    const float moved  = measured->travelled_n - x->travelled_n;
    const float travel = magnitude(moved);

    x->stop[0] = bound_f32(x->stop[0] + moved * params->measured_per_n, 1.0f);
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        x->stop[j + 1u] = bound_f32(x->stop[j + 1u] + moved * params->stop_per_n[j], 1.0f);
    }
    // A force that slides to and fro in quick succession hunts, and its friction is not that of a slide.
    const float  widest = x->stop[TRIBO_FEEDFORWARD_STOPS];
    const int8_t side   = (int8_t)(magnitude(widest) >= 1.0f ? bank_f32_sign(widest) : x->side);
    if (side != x->side)
    {
        x->hunts = x->since < params->quick_ticks / 2u;
        x->since = 0;
    }
    else if (x->since < params->quick_ticks / 2u)
    {
        x->since += FEEDFORWARD_STAGES;
    }
    const bool hunts = x->hunts && x->since < params->quick_ticks / 2u;
    const bool slips = !(travel <= params->slip_n);

    x->side        = side;
    x->jump_n      = measured->friction_n - x->friction_n;
    x->friction_n  = measured->friction_n;
    x->force_n     = measured->force_n;
    x->travelled_n = measured->travelled_n;
    x->sample_n    = allowed && !hunts && !slips ? limit_f32(travel, 0.0f, params->travel_max_n) : 0.0f;
}

/// Stage 1: the regressor, and the error of what is known.
static inline void learning_f32_regressor(const tribo_feedforward_f32_params_t   *params,
                                          const tribo_friction_f32_params_t      *friction,
                                          const tribo_feedforward_weights_f32_t  *learned,
                                          tribo_feedforward_learning_f32_state_t *x)
{
    const bank_f32_prior_t prior = bank_f32_prior(friction, x->force_n);
    const float            per_L = 1.0f / prior.L_n;
    float *const           k     = x->regressor;

    const float load  = bank_f32_load(learned, x->force_n);
    float       error = (x->friction_n - (prior.load_n + load)) * per_L;
    error -= learned->weight[0] * x->stop[0];
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        const float psi = x->stop[j + 1u] - x->stop[j];
        error -= learned->weight[j + 1u] * psi;
        k[4u + j] = FEEDFORWARD_STOP_SD * psi;
    }
    k[0] = FEEDFORWARD_WEIGHT_SD * x->stop[0];
    k[1] = limit_f32(params->constant_sd_n * per_L, 0.0f, FEEDFORWARD_LOAD_MAX);
    k[2] = limit_f32(FEEDFORWARD_SLOPE_SD * magnitude(x->force_n) * per_L, 0.0f, FEEDFORWARD_LOAD_MAX);
    k[3] = x->force_n < 0.0f ? -k[2] : k[2];
    // While friction changes quickly, z lags behind the stops.
    const float jump = bound_f32(x->jump_n * params->jump_lag * per_L, FEEDFORWARD_JUMP_MAX);
    x->weighing_n    = params->weighing_n * (1.0f + jump * jump);
    x->error         = error;
    x->load          = load * per_L;
}

/// q = M k.
static inline void learning_f32_times(const float M[10], const float k[4], float q[4])
{
    q[0] = M[0] * k[0] + M[1] * k[1] + M[2] * k[2] + M[3] * k[3];
    q[1] = M[1] * k[0] + M[4] * k[1] + M[5] * k[2] + M[6] * k[3];
    q[2] = M[2] * k[0] + M[5] * k[1] + M[7] * k[2] + M[8] * k[3];
    q[3] = M[3] * k[0] + M[6] * k[1] + M[8] * k[2] + M[9] * k[3];
}

/// Stage 2: q = M k and P kappa.
static inline void learning_f32_gained(const tribo_feedforward_weights_f32_t  *learned,
                                       tribo_feedforward_learning_f32_state_t *x)
{
    learning_f32_times(learned->covariance, x->regressor, x->gained);
    for (uint32_t j = 4; j < 4u + TRIBO_FEEDFORWARD_STOPS; j++)
    {
        x->gained[j] = learned->variance[j - 4u] * x->regressor[j];
    }
}

/// Variance of V_0 and the load where friction has the sign `sign`, over the prior's, at the last sample's force: a direction that
/// has not slid is known only as far as it is the other's mirror image.
static inline float learning_f32_relative_variance(const tribo_feedforward_weights_f32_t        *learned,
                                                   const tribo_feedforward_learning_f32_state_t *x,
                                                   float                                         sign)
{
    const float k[4] = {FEEDFORWARD_WEIGHT_SD, sign * x->regressor[1], sign * x->regressor[2], sign * x->regressor[3]};
    float       q[4];
    float       now   = 0.0f;
    float       prior = 0.0f;
    learning_f32_times(learned->covariance, k, q);
    for (uint32_t i = 0; i < 4u; i++)
    {
        now += q[i] * k[i];
        prior += k[i] * k[i];
    }
    return limit_f32(now / prior, 0.0f, 1.0f);
}

/// Stage 3: the gain of the sample.
static inline void learning_f32_gain(tribo_feedforward_learning_f32_state_t *x)
{
    float spread = 0.0f;
    for (uint32_t i = 0; i < 4u + TRIBO_FEEDFORWARD_STOPS; i++)
    {
        spread += x->gained[i] * x->regressor[i];
    }
    const float S = limit_f32(spread, 0.0f, FEEDFORWARD_FORCE_MAX_N);
    x->gain       = x->sample_n / (x->weighing_n + x->sample_n * S);
    // A surprise beyond two standard deviations is a push, not friction.
    const float most   = FEEDFORWARD_SURPRISE * (S + FEEDFORWARD_MODEL_ERROR);
    const float square = x->error * x->error;
    if (square > most)
    {
        x->gain *= most / square;
    }
}

/// The sample's travel over that of a constant, at most 1.
static inline float learning_f32_part(const tribo_feedforward_learning_f32_state_t *x, float per_n)
{
    return limit_f32(x->sample_n * per_n, 0.0f, 1.0f);
}

/// A learned number within its bounds; it stays if its change is not a number.
static inline float learning_f32_moved(float before, float by, float min, float max)
{
    const float after = before + by;
    return exceeds(after, FEEDFORWARD_FORCE_MAX_N) ? before : limit_f32(after, min, max);
}

/// Stage 4: the weights.
static inline void learning_f32_weights(tribo_feedforward_weights_f32_t              *learned,
                                        const tribo_feedforward_learning_f32_state_t *x)
{
    const float        step = x->gain * x->error;
    const float *const q    = x->gained;
    float *const       V    = learned->weight;

    V[0] =
        learning_f32_moved(V[0], FEEDFORWARD_WEIGHT_SD * (step * q[0]), FEEDFORWARD_WEIGHT_MIN, FEEDFORWARD_WEIGHT_MAX);
    for (uint32_t j = 1; j <= TRIBO_FEEDFORWARD_STOPS; j++)
    {
        const float by = FEEDFORWARD_STOP_SD * (step * q[3u + j]);
        V[j]           = learning_f32_moved(V[j], by, -FEEDFORWARD_STOP_MAX, FEEDFORWARD_STOP_MAX);
    }
}

/// Stage 5: the load that does not reverse. b takes its change.
static inline void learning_f32_load(const tribo_feedforward_f32_params_t *params, tribo_feedforward_f32_state_t *state)
{
    const tribo_feedforward_learning_f32_state_t *const x       = &state->learning;
    tribo_feedforward_weights_f32_t *const              learned = &state->learned;

    const float before      = bank_f32_load(learned, state->reached_n);
    const float step        = x->gain * x->error;
    const float by_constant = params->constant_sd_n * (step * x->gained[1]);
    const float by_slope    = FEEDFORWARD_SLOPE_SD * (step * x->gained[2]);
    const float by_scale    = FEEDFORWARD_SLOPE_SD * (step * x->gained[3]);
    const float most        = params->constant_max_n;

    learned->constant_n = learning_f32_moved(learned->constant_n, by_constant, -most, most);
    learned->slope      = learning_f32_moved(learned->slope, by_slope, -FEEDFORWARD_SLOPE_MAX, FEEDFORWARD_SLOPE_MAX);
    learned->scale      = learning_f32_moved(learned->scale, by_scale, -FEEDFORWARD_SLOPE_MAX, FEEDFORWARD_SLOPE_MAX);
    state->offset_n += bank_f32_load(learned, state->reached_n) - before;
}

/// The bits of the numbers that a reversal changes.
static inline uint32_t learning_f32_fold_turned(const tribo_feedforward_weights_f32_t *x)
{
    return bits_f32(x->weight[0]) ^ bits_f32(x->use[0]) ^ learning_f32_fold_stage(x, 5);
}

/// At a reversal of r: slides in one direction cannot tell less friction from a load. As far as no other has slid, all that
/// friction lacks is taken for less friction, lest F be pushed beyond its reversal.
static inline void learning_f32_turn(tribo_feedforward_weights_f32_t        *learned,
                                     tribo_feedforward_learning_f32_state_t *x)
{
    const float per_M   = 1.0f / (FEEDFORWARD_ONE_WAY - FEEDFORWARD_BOTH_WAYS);
    const float one_way = limit_f32((learned->covariance[0] - FEEDFORWARD_BOTH_WAYS) * per_M, 0.0f, 1.0f);
    const float lack    = -x->stop[0] * one_way * x->load;
    if (!(lack > 0.0f))
    {
        return;
    }
    const float both = 1.0f - one_way;
    const float V    = learned->weight[0] - FEEDFORWARD_LACK * lack;
    learned->seal ^= learning_f32_fold_turned(learned);
    learned->use[0] -= learned->weight[0];
    learned->weight[0] = limit_f32(V, FEEDFORWARD_WEIGHT_MIN, FEEDFORWARD_WEIGHT_MAX);
    learned->use[0] += learned->weight[0];
    learned->constant_n *= both;
    learned->slope *= both;
    learned->scale *= both;
    x->load *= both;
    learned->seal ^= learning_f32_fold_turned(learned);
}

/// n_y, over the travel in which doubt falls.
static inline float learning_f32_noise(const tribo_feedforward_f32_params_t *params,
                                       const tribo_feedforward_f32_state_t  *state)
{
    return state->observer.noise_n * params->doubt_per_n;
}

/// Stage 5: part of the stops' weights that is used: none before they are sure to be more than the creep at a jump, and `noise`.
static inline float learning_f32_presliding(const float *V, float noise)
{
    const float least = FEEDFORWARD_PRESLIDING_MIN + FEEDFORWARD_PRESLIDING_NOISE * noise;

    float squares = 0.0f;
    for (uint32_t j = 1; j <= TRIBO_FEEDFORWARD_STOPS; j++)
    {
        squares += V[j] * V[j];
    }
    const float ratio = squares > least ? least / squares : 1.0f;
    return 1.0f - ratio * ratio;
}

/// Stage 6: what is used of the weights. Small ones of stops, possibly noise, shrink, and in noise less friction than learned is safer.
/// b takes the change of f at `level`.
static inline void learning_f32_use(const tribo_feedforward_f32_params_t *params,
                                    tribo_feedforward_f32_state_t        *state,
                                    float                                 level)
{
    const tribo_feedforward_learning_f32_state_t *const x       = &state->learning;
    tribo_feedforward_weights_f32_t *const              learned = &state->learned;

    const float *const V    = learned->weight;
    float *const       W    = learned->use;
    float              last = 0.0f;
    for (uint32_t j = TRIBO_FEEDFORWARD_STOPS; j > 0u; j--)
    {
        const float V2 = V[j] * V[j];
        const float S  = x->presliding * V[j] * (V2 / (V2 + FEEDFORWARD_SHRINK * FEEDFORWARD_SHRINK));
        W[j]           = S - last;
        last           = S;
    }
    const float spared = FEEDFORWARD_SPARED * x->regressor[1] * learning_f32_noise(params, state);
    W[0]               = V[0] - last - limit_f32(spared, 0.0f, FEEDFORWARD_SPARED_MAX * V[0]);
    learned->travel_n += x->sample_n;
    learned->doubt *= 1.0f - learning_f32_part(x, params->doubt_per_n);

    const float f = bank_f32_friction(params, learned, level, bank_f32_partial(state), state->sigma);
    state->offset_n += f - state->f_n;
    state->f_n = f;
}

/// A variance over the prior's that drops with a sample, and returns to the prior's by `part`.
static inline float learning_f32_left(float variance, float drop, float part)
{
    return limit_f32(first_order_f32_step(variance - drop, 1.0f, part), 0.0f, 1.0f);
}

/// Stages 7 and 8: two rows of the covariance, from row `i` at `M`.
static inline void learning_f32_covariance(const tribo_feedforward_learning_f32_state_t *x,
                                           float                                        *M,
                                           uint32_t                                      i,
                                           float                                         part)
{
    for (uint32_t end = i + 2u; i < end; i++)
    {
        const float drop = x->gain * x->gained[i];
        *M               = learning_f32_left(*M, drop * x->gained[i], part);
        M++;
        for (uint32_t j = i + 1u; j < 4u; j++)
        {
            *M = bound_f32(first_order_f32_step(*M - drop * x->gained[j], 0.0f, part), 1.0f);
            M++;
        }
    }
}

/// Stage 8: the stops' variances.
static inline void learning_f32_variance(const tribo_feedforward_learning_f32_state_t *x, float *P, float part)
{
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        const float q = x->gained[4u + j];
        P[j]          = learning_f32_left(P[j], x->gain * q * q, part);
    }
}

/// Stages 1 to 8 of a sample. `level` of friction at rs.
static inline void learning_f32_work(const tribo_feedforward_f32_params_t *params,
                                     const tribo_friction_f32_params_t    *friction,
                                     tribo_feedforward_f32_state_t        *state,
                                     uint32_t                              stage,
                                     float                                 level)
{
    tribo_feedforward_learning_f32_state_t *const x       = &state->learning;
    tribo_feedforward_weights_f32_t *const        learned = &state->learned;

    switch (stage)
    {
    case 1:
        learning_f32_regressor(params, friction, learned, x);
        break;
    case 2:
        learning_f32_gained(learned, x);
        break;
    case 3:
        learning_f32_gain(x);
        break;
    case 4:
        learning_f32_weights(learned, x);
        state->hold.extra_margin *= 1.0f - learning_f32_part(x, params->margin_per_n);
        break;
    case 5:
        learning_f32_load(params, state);
        x->presliding = learning_f32_presliding(learned->weight, learning_f32_noise(params, state));
        break;
    case 6:
        learning_f32_use(params, state, level);
        break;
    case 7:
        learning_f32_covariance(x, &learned->covariance[0], 0, learning_f32_part(x, params->forgetting_per_n));
        break;
    case 8: {
        const float part = learning_f32_part(x, params->forgetting_per_n);
        learning_f32_covariance(x, &learned->covariance[7], 2, part);
        learning_f32_variance(x, learned->variance, part);
        break;
    }
    default: // 0 is done, 9 is of the method
        break;
    }
}

/// One tick: one stage. `level` of friction at rs, `allowed` as in stage 0. b takes what learning changes.
static inline void learning_f32_step(const tribo_feedforward_f32_params_t *params,
                                     const tribo_friction_f32_params_t    *friction,
                                     tribo_feedforward_f32_state_t        *state,
                                     float                                 level,
                                     bool                                  allowed)
{
    tribo_feedforward_learning_f32_state_t *const x       = &state->learning;
    tribo_feedforward_weights_f32_t *const        learned = &state->learned;

    const uint32_t stage = x->stage;
    x->stage             = (uint8_t)(stage + 1u < FEEDFORWARD_STAGES ? stage + 1u : 0u);
    if (stage == 0u)
    {
        learning_f32_sample(params, &state->observer, x, allowed);
        x->seal = 0;
    }
    if (!(x->sample_n > 0.0f))
    {
        return;
    }
    learned->seal ^= learning_f32_fold_stage(learned, stage);
    learning_f32_work(params, friction, state, stage, level);
    x->seal ^= learning_f32_fold_sample(x, stage);
    learned->seal ^= learning_f32_fold_stage(learned, stage);
}

#endif
