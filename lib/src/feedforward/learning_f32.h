// Learning of friction over the prior, single precision: step 12 of docs/feedforward.md.
//
// Weighted least squares in which the travelled distance weighs, as friction is a matter of distance:
//
//     z/L = V0 Psi0 + ... + V4 Psi4 + (D + c0 + c1 |yf| + c2 yf)/L        Psi_j: stop j less stop j-1, on the measured force
//
// with the full covariance M of V0 and c0 to c2, and a variance P each for V1 to V4, all over the prior's. A sample is worked off in
// four ticks: sample, gain, weights, covariance. No loops but the stops'; at most four divisions a tick.
// Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_LEARNING_F32_H
#define TRIBO_FEEDFORWARD_LEARNING_F32_H

#include "tribo/feedforward_f32.h"

#include "../number/ieee_f32.h"
#include "bank_f32.h"
#include "constants.h"
#include "observer_f32.h"

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
}

/// True if a learned number is beyond its bounds, or NaN: its memory is corrupt.
static inline bool learning_f32_corrupt(const tribo_feedforward_f32_params_t  *params,
                                        const tribo_feedforward_weights_f32_t *x)
{
    bool bad = !within(x->weight[0], FEEDFORWARD_WEIGHT_MIN, FEEDFORWARD_WEIGHT_MAX) ||
               exceeds(x->constant_n, params->constant_max_n) || exceeds(x->slope, FEEDFORWARD_SLOPE_MAX) ||
               exceeds(x->scale, FEEDFORWARD_SLOPE_MAX) || !within(x->doubt, 0.0f, 1.0f);
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        bad = bad || exceeds(x->weight[j + 1u], FEEDFORWARD_STOP_MAX);
    }
    return bad;
}

/// Stage 0: the sample of this tick.
static inline void learning_f32_sample(const tribo_feedforward_f32_params_t         *params,
                                       const tribo_friction_f32_params_t            *friction,
                                       const tribo_feedforward_observer_f32_state_t *observer,
                                       const tribo_feedforward_weights_f32_t        *learned,
                                       tribo_feedforward_learning_f32_state_t       *x,
                                       const observer_f32_signals_t                 *measured)
{
    const float            force = observer->force_n;
    const bank_f32_prior_t prior = bank_f32_prior(friction, force);
    const float            per_L = 1.0f / prior.L_n;

    float error = (measured->friction_n - bank_f32_load(learned, &prior, force)) * per_L;
    float last  = 0.0f;
    float psi[1u + TRIBO_FEEDFORWARD_STOPS];
    for (uint32_t j = 0; j <= TRIBO_FEEDFORWARD_STOPS; j++)
    {
        psi[j] = observer->stop[j] - last;
        last   = observer->stop[j];
        error -= learned->weight[j] * psi[j];
    }
    x->regressor[0] = FEEDFORWARD_WEIGHT_SD * psi[0];
    x->regressor[1] = limit_f32(params->constant_sd_n * per_L, 0.0f, FEEDFORWARD_LOAD_MAX);
    x->regressor[2] = limit_f32(FEEDFORWARD_SLOPE_SD * magnitude(force) * per_L, 0.0f, FEEDFORWARD_LOAD_MAX);
    x->regressor[3] = force < 0.0f ? -x->regressor[2] : x->regressor[2];
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        x->regressor[4u + j] = FEEDFORWARD_STOP_SD * psi[j + 1u];
    }
    // While friction changes quickly, z lags behind the stops.
    const float jump = bound_f32(measured->jump_n * params->jump_lag * per_L, FEEDFORWARD_JUMP_MAX);
    x->weighing_n    = params->weighing_n * (1.0f + jump * jump);

    x->error    = error;
    x->sample_n = x->travel_n;
    x->travel_n = 0.0f;
}

/// Stage 1: q = M k and P kappa, and the gain of the sample.
static inline void learning_f32_gain(const tribo_feedforward_weights_f32_t  *learned,
                                     tribo_feedforward_learning_f32_state_t *x)
{
    const float *const M      = learned->covariance;
    const float *const k      = x->regressor;
    float *const       q      = x->gained;
    float              spread = 0.0f;

    q[0] = M[0] * k[0] + M[1] * k[1] + M[2] * k[2] + M[3] * k[3];
    q[1] = M[1] * k[0] + M[4] * k[1] + M[5] * k[2] + M[6] * k[3];
    q[2] = M[2] * k[0] + M[5] * k[1] + M[7] * k[2] + M[8] * k[3];
    q[3] = M[3] * k[0] + M[6] * k[1] + M[8] * k[2] + M[9] * k[3];
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        q[4u + j] = learned->variance[j] * k[4u + j];
    }
    for (uint32_t i = 0; i < 4u + TRIBO_FEEDFORWARD_STOPS; i++)
    {
        spread += q[i] * k[i];
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

/// Part of the stops' weights that is used: none before they are sure to be more than the creep at a jump.
static inline float learning_f32_presliding(float squares)
{
    const float ratio = squares > FEEDFORWARD_PRESLIDING_MIN ? FEEDFORWARD_PRESLIDING_MIN / squares : 1.0f;
    return 1.0f - ratio * ratio;
}

/// A weight for use: small ones, possibly noise, shrink.
static inline float learning_f32_shrunk(float V)
{
    const float V2 = V * V;
    return V * (V2 / (V2 + FEEDFORWARD_SHRINK * FEEDFORWARD_SHRINK));
}

/// A learned number within its bounds; it stays if its change is not a number.
static inline float learning_f32_moved(float before, float by, float min, float max)
{
    const float after = before + by;
    return exceeds(after, FEEDFORWARD_FORCE_MAX_N) ? before : limit_f32(after, min, max);
}

/// Stage 2: what is learned.
static inline void learning_f32_weights(const tribo_feedforward_f32_params_t         *params,
                                        tribo_feedforward_weights_f32_t              *learned,
                                        const tribo_feedforward_learning_f32_state_t *x)
{
    const float  step = x->gain * x->error;
    float *const V    = learned->weight;
    float *const W    = learned->use;

    const float by_constant = params->constant_sd_n * (step * x->gained[1]);
    const float by_slope    = FEEDFORWARD_SLOPE_SD * (step * x->gained[2]);
    const float by_scale    = FEEDFORWARD_SLOPE_SD * (step * x->gained[3]);
    const float by_sliding  = FEEDFORWARD_WEIGHT_SD * (step * x->gained[0]);
    const float most        = params->constant_max_n;

    learned->constant_n = learning_f32_moved(learned->constant_n, by_constant, -most, most);
    learned->slope      = learning_f32_moved(learned->slope, by_slope, -FEEDFORWARD_SLOPE_MAX, FEEDFORWARD_SLOPE_MAX);
    learned->scale      = learning_f32_moved(learned->scale, by_scale, -FEEDFORWARD_SLOPE_MAX, FEEDFORWARD_SLOPE_MAX);
    V[0]                = learning_f32_moved(V[0], by_sliding, FEEDFORWARD_WEIGHT_MIN, FEEDFORWARD_WEIGHT_MAX);

    float squares = 0.0f;
    for (uint32_t j = 1; j <= TRIBO_FEEDFORWARD_STOPS; j++)
    {
        const float by = FEEDFORWARD_STOP_SD * (step * x->gained[3u + j]);
        V[j]           = learning_f32_moved(V[j], by, -FEEDFORWARD_STOP_MAX, FEEDFORWARD_STOP_MAX);
        squares += V[j] * V[j];
    }
    const float part = learning_f32_presliding(squares);
    float       last = 0.0f;
    for (uint32_t j = TRIBO_FEEDFORWARD_STOPS; j > 0u; j--)
    {
        const float S = part * learning_f32_shrunk(V[j]);
        W[j]          = S - last;
        last          = S;
    }
    W[0] = V[0] - last;
    learned->travel_n += x->sample_n;
    learned->doubt *= 1.0f - limit_f32(x->sample_n * params->doubt_per_n, 0.0f, 1.0f);
}

/// Stage 3: the variance after the sample, and forgetting towards the prior's.
static inline void learning_f32_covariance(const tribo_feedforward_f32_params_t         *params,
                                           tribo_feedforward_weights_f32_t              *learned,
                                           const tribo_feedforward_learning_f32_state_t *x)
{
    const float        part = limit_f32(x->sample_n * params->forgetting_per_n, 0.0f, 1.0f);
    const float *const q    = x->gained;
    float *const       M    = learned->covariance;

    for (uint32_t i = 0, at = 0; i < 4u; i++)
    {
        for (uint32_t j = i; j < 4u; j++, at++)
        {
            const bool  own   = i == j;
            const float after = M[at] - x->gain * q[i] * q[j];
            M[at] = limit_f32(first_order_f32_step(after, own ? 1.0f : 0.0f, part), own ? 0.0f : -1.0f, 1.0f);
        }
    }
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        float *const P     = &learned->variance[j];
        const float  after = *P - x->gain * q[4u + j] * q[4u + j];
        *P                 = limit_f32(first_order_f32_step(after, 1.0f, part), 0.0f, 1.0f);
    }
}

/// One tick. `learns`: the measurement is one of friction. True when stage 2 has changed what is learned.
static inline bool learning_f32_step(const tribo_feedforward_f32_params_t *params,
                                     const tribo_friction_f32_params_t    *friction,
                                     tribo_feedforward_f32_state_t        *state,
                                     const observer_f32_signals_t         *measured,
                                     bool                                  learns)
{
    tribo_feedforward_learning_f32_state_t *const x       = &state->learning;
    tribo_feedforward_weights_f32_t *const        learned = &state->learned;

    x->travel_n = limit_f32(x->travel_n + (learns ? magnitude(measured->travel_n) : 0.0f), 0.0f, params->travel_max_n);
    switch (x->stage)
    {
    case 1:
        learning_f32_gain(learned, x);
        x->stage = 2;
        return false;
    case 2:
        learning_f32_weights(params, learned, x);
        state->hold.extra_margin *= 1.0f - limit_f32(x->sample_n * params->margin_per_n, 0.0f, 1.0f);
        x->stage = 3;
        return true;
    case 3:
        learning_f32_covariance(params, learned, x);
        x->stage = 0;
        return false;
    default:
        x->stage = 0;
        if (learns && x->travel_n > 0.0f)
        {
            learning_f32_sample(params, friction, &state->observer, learned, x, measured);
            x->stage = 1;
        }
        return false;
    }
}

#endif
