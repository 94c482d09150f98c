// The bank of stops on the reference, single precision: steps 2 to 6 of docs/feedforward.md.
//
//     f(sigma) = G (W0 sigma + W1 phi1 + W2 phi2 + W3 phi3 + W4 phi4)
//
//     phi  +1        .------     a stop: the force of an elastic element that slides at its width d
//                   /
//                  /             sigma, a stop of no width, ramps in time instead
//          -1 ----'
//               |<2 d>|--> rs
//
// No divisions but the table's. Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_BANK_F32_H
#define TRIBO_FEEDFORWARD_BANK_F32_H

#include "tribo/feedforward_f32.h"
#include "tribo/friction_f32.h"

#include "../friction/law_f32.h"
#include "../number/first_order_f32.h"
#include "constants.h"

/// The model's breakaway at a force.
typedef struct
{
    float L_n;    ///< half of the jump at a reversal
    float load_n; ///< D, which does not reverse
} bank_f32_prior_t;

static inline bank_f32_prior_t bank_f32_prior(const tribo_friction_f32_params_t *friction, float force)
{
    const float load    = magnitude(force);
    float       both[2] = {friction_f32_affine(&friction->law[0], load), friction_f32_affine(&friction->law[1], load)};
    if (friction->table_length > 0u)
    {
        tribo_friction_f32_look_up(friction, load, both);
    }
    return (bank_f32_prior_t){.L_n    = 0.5f * (both[0] + both[1]),
                              .load_n = 0.5f * (both[0] - both[1]) - friction->gravity_n};
}

/// Load that does not reverse, as learned beside the model's.
static inline float bank_f32_load(const tribo_feedforward_weights_f32_t *learned, float force)
{
    return learned->constant_n + learned->slope * magnitude(force) + learned->scale * force;
}

static inline int32_t bank_f32_sign(float x)
{
    return (x > 0.0f) - (x < 0.0f);
}

/// Step 2, of r or y: the mean second difference of `now` and the two values before it. Each tick counts at most four times the
/// mean, so that reversals and steps are not noise.
static inline float bank_f32_noise(const tribo_feedforward_f32_params_t *params, float mean, float now, float last[2])
{
    const float second = magnitude((now - last[0]) - (last[0] - last[1]));
    const float most   = FEEDFORWARD_NOISE_PEAK * mean + params->noise_floor_n;
    const float next   = first_order_f32_step(mean, second < most ? second : most, params->noise_part);
    last[1]            = last[0];
    last[0]            = now;
    return exceeds(next, FEEDFORWARD_FORCE_MAX_N) ? 0.0f : next;
}

/// Step 3: rs follows r, but not further into a limit of u. Returns its move.
static inline float bank_f32_reach(const tribo_feedforward_f32_params_t *params,
                                   tribo_feedforward_f32_state_t        *state,
                                   float                                 r)
{
    const float wanted = r - state->reached_n;
    const float moved  = wanted * (float)state->limited > 0.0f ? 0.0f : wanted;
    const bool  step   = magnitude(moved) > params->step_n;
    state->reached_n += moved;
    state->rate_n_s = first_order_f32_step(state->rate_n_s, step ? 0.0f : moved * params->rate_hz, params->rate_part);
    return moved;
}

/// Step 4: the stops, for w_n.
static inline void bank_f32_slide(const tribo_feedforward_f32_params_t *params,
                                  tribo_feedforward_f32_state_t        *state,
                                  float                                 noise_width)
{
    const float rs      = state->reached_n;
    const float settled = limit_f32(state->settled_n, rs - 0.5f * noise_width, rs + 0.5f * noise_width);
    const float moved   = settled - state->settled_n;
#pragma GCC unroll 4
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        state->stop[j] = bound_f32(state->stop[j] + moved * params->stop_per_n[j], 1.0f);
    }
    state->settled_n = settled;
}

/// Step 4: the sign of rs, of its last move by more than `width`.
static inline void bank_f32_turn(tribo_feedforward_f32_state_t *state, float width)
{
    const float rs     = state->reached_n;
    const float turned = limit_f32(state->turned_n, rs - 0.5f * width, rs + 0.5f * width);
    state->sign        = (int8_t)(turned != state->turned_n ? bank_f32_sign(turned - state->turned_n) : state->sign);
    state->turned_n    = turned;
}

/// Step 5: the model of the path, for a move of rs and the lead of lin before it, as distances from rs.
static inline void bank_f32_path(const tribo_feedforward_f32_params_t *params,
                                 tribo_feedforward_f32_state_t        *state,
                                 float                                 moved,
                                 float                                 ahead)
{
    float *const behind = state->behind_n;
    behind[0]           = first_order_f32_step(behind[0] - moved, ahead, params->lag_part);
    behind[1]           = first_order_f32_step(behind[1] - moved, behind[0], params->sensor_part);
}

/// W1 phi1 + ... + W4 phi4.
static inline float bank_f32_partial(const tribo_feedforward_f32_state_t *state)
{
    const float *const use = state->learned.use;
    float              sum = 0.0f;
#pragma GCC unroll 4
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        sum += use[j + 1u] * state->stop[j];
    }
    return sum;
}

/// f(sigma), for a `level` of L(rs) and the shares of guard and monitor.
static inline float bank_f32_friction(const tribo_feedforward_f32_params_t  *params,
                                      const tribo_feedforward_weights_f32_t *learned,
                                      float                                  level,
                                      float                                  partial,
                                      float                                  sigma)
{
    const float sum = bound_f32(partial + learned->use[0] * sigma, FEEDFORWARD_F_MAX);
    return (1.0f - params->distrust * learned->doubt) * level * sum;
}

/// f(1) - f(0).
static inline float bank_f32_rise(const tribo_feedforward_f32_params_t  *params,
                                  const tribo_feedforward_weights_f32_t *learned,
                                  float                                  level)
{
    return (1.0f - params->distrust * learned->doubt) * level * learned->use[0];
}

#endif
