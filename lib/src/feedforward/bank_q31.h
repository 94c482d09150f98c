// The bank of stops on the reference in fixed point; bank_f32.h has the equations, feedforward_q31.h the formats.
//
// Products are rounded towards zero, so mirrored forces give mirrored results. No divisions but the table's.
// Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_BANK_Q31_H
#define TRIBO_FEEDFORWARD_BANK_Q31_H

#include "tribo/feedforward_q31.h"
#include "tribo/friction_q31.h"
#include "tribo/q31.h"

#include "../friction/law_q31.h"
#include "../number/first_order_q31.h"
#include "constants.h"

#define BANK_Q31_ONE       (INT32_C(1) << 29)  // FS, or 1
#define BANK_Q31_NOISE_MAX (UINT32_C(1) << 31) // FS/64

/// Noise of Q37 over this is `gain`, a power of 2, times the noise in Q29, rounded once.
#define BANK_Q31_NOISE_PER(gain) (256u / (uint32_t)(gain))

/// A constant of Q29 or, for 0 to below 1, of Q32.
#define BANK_Q31_Q29(x) ((int32_t)((double)(x) * 536870912.0 + 0.5))
#define BANK_Q31_Q32(x) ((uint32_t)((double)(x) * 4294967296.0 + 0.5))

/// Q31 to Q29, mirrored for mirrored forces.
static inline int32_t bank_q31_inside(int32_t x)
{
    return x / 4;
}

/// Q29 to Q31, within full scale.
static inline int32_t bank_q31_outside(int32_t x)
{
    return 4 * limit_q31(x, 1 - BANK_Q31_ONE, BANK_Q31_ONE - 1);
}

/// x times `gain` of `fraction` bits, within +-`most`.
static inline int32_t bank_q31_times(int32_t x, uint32_t gain, uint32_t fraction, uint32_t most)
{
    const uint64_t product = tribo_q31_product(tribo_q31_magnitude(x), gain) >> fraction;
    const int32_t  size    = (int32_t)(product < most ? (uint32_t)product : most);
    return x < 0 ? -size : size;
}

/// The product of two numbers of Q29.
static inline int32_t bank_q31_product(int32_t a, int32_t b)
{
    const int32_t size = bank_q31_times(a, tribo_q31_magnitude(b), 29, INT32_MAX);
    return b < 0 ? -size : size;
}

/// x times a fraction of Q32; UINT32_MAX is all of it.
static inline uint32_t bank_q31_share(uint32_t x, uint32_t fraction)
{
    return fraction == UINT32_MAX ? x : tribo_q31_high(x, fraction);
}

/// The model's breakaway at a force.
typedef struct
{
    uint32_t L;    ///< half of the jump at a reversal, up to FS
    int32_t  load; ///< D, which does not reverse, within +-1.5 FS
} bank_q31_prior_t;

static inline bank_q31_prior_t bank_q31_prior(const tribo_friction_q31_params_t *friction, int32_t force)
{
    const uint32_t load = 4u * tribo_q31_magnitude(limit_q31(force, 1 - BANK_Q31_ONE, BANK_Q31_ONE - 1)); // Q31

    uint32_t both[2] = {friction_q31_affine(&friction->law[0], load), friction_q31_affine(&friction->law[1], load)};
    if (!friction->is_shallow)
    {
        tribo_friction_q31_look_up(friction, load, both);
    }
    return (bank_q31_prior_t){.L    = (both[0] + both[1]) / 8u,
                              .load = ((int32_t)both[0] - (int32_t)both[1]) / 8 - bank_q31_inside(friction->gravity)};
}

/// Load that does not reverse, as learned beside the model's, within +-2 FS.
static inline int32_t bank_q31_load(const tribo_feedforward_weights_q31_t *learned, int32_t force)
{
    const int32_t slope =
        force < 0 ? difference_q31(learned->slope, learned->scale) : sum_q31(learned->slope, learned->scale);
    return sum_q31(bank_q31_times(slope, tribo_q31_magnitude(force), 29, (uint32_t)BANK_Q31_ONE), learned->constant);
}

/// The model's and the learned load, within +-FS.
static inline int32_t bank_q31_both(const bank_q31_prior_t *prior, int32_t learned)
{
    const int32_t known = limit_q31(prior->load, -BANK_Q31_ONE, BANK_Q31_ONE);
    return limit_q31(sum_q31(known, learned), -BANK_Q31_ONE, BANK_Q31_ONE);
}

static inline int32_t bank_q31_sign(int32_t x)
{
    return (x > 0) - (x < 0);
}

/// x times a fraction of Q32, to nearest.
static inline uint32_t bank_q31_near(uint32_t x, uint32_t fraction)
{
    return (uint32_t)((tribo_q31_product(x, fraction) + (UINT64_C(1) << 31)) >> 32);
}

/// A low pass of a positive number. Rounded towards zero, a slow one would lag behind by up to 1/part units.
static inline uint32_t bank_q31_pass(uint32_t x, uint32_t input, uint32_t part)
{
    return input > x ? x + bank_q31_near(input - x, part) : x - bank_q31_near(x - input, part);
}

/// |now - 2 last[0] + last[1]| in Q37; a second difference of up to 2^31 wraps to a number of the same magnitude.
static inline uint32_t bank_q31_second(int32_t now, const int32_t last[2])
{
    const int32_t  change = difference_q31(now, last[0]);
    const uint32_t second = tribo_q31_magnitude(difference_q31(change, difference_q31(last[0], last[1])));
    return second < BANK_Q31_NOISE_MAX >> 8 ? second << 8 : BANK_Q31_NOISE_MAX;
}

static inline uint32_t bank_q31_noise(const tribo_feedforward_q31_params_t *params,
                                      uint32_t                              mean,
                                      int32_t                               now,
                                      int32_t                               last[2])
{
    const uint32_t second = bank_q31_second(now, last);
    const uint32_t most = mean < BANK_Q31_NOISE_MAX >> 2 ? (uint32_t)FEEDFORWARD_NOISE_PEAK * mean + params->noise_floor
                                                         : BANK_Q31_NOISE_MAX;
    last[1]             = last[0];
    last[0]             = now;
    return bank_q31_pass(mean, second < most ? second : most, params->noise_part);
}

static inline int32_t bank_q31_reach(const tribo_feedforward_q31_params_t *params,
                                     tribo_feedforward_q31_state_t        *state,
                                     int32_t                               r)
{
    const int32_t wanted = difference_q31(r, state->reached);
    const int32_t moved  = bank_q31_sign(wanted) * state->limited > 0 ? 0 : wanted;
    const bool    step   = tribo_q31_magnitude(moved) > (uint32_t)params->step;
    state->reached = limit_q31(sum_q31(state->reached, moved), -BANK_Q31_ONE, BANK_Q31_ONE); // a corrupt one recovers
    state->rate    = first_order_q31_step(state->rate, step ? 0 : moved * 256, params->rate_part);
    return moved;
}

static inline int32_t bank_q31_stop(int32_t stop, int32_t moved, uint32_t per_unit)
{
    const int32_t by = bank_q31_times(moved, per_unit, 10, 2u * (uint32_t)BANK_Q31_ONE);
    return limit_q31(sum_q31(stop, by), -BANK_Q31_ONE, BANK_Q31_ONE); // a corrupt one recovers
}

static inline void bank_q31_slide(const tribo_feedforward_q31_params_t *params,
                                  tribo_feedforward_q31_state_t        *state,
                                  uint32_t                              noise_width)
{
    const int32_t rs      = state->reached;
    const int32_t half    = (int32_t)(noise_width / 2u);
    const int32_t settled = limit_q31(state->settled, rs - half, rs + half);
    const int32_t moved   = difference_q31(settled, state->settled);
#pragma GCC unroll 4
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        state->stop[j] = bank_q31_stop(state->stop[j], moved, params->stop_per_unit[j]);
    }
    state->settled = settled;
}

static inline void bank_q31_turn(tribo_feedforward_q31_state_t *state, uint32_t width)
{
    const int32_t rs     = state->reached;
    const int32_t half   = (int32_t)(width / 2u);
    const int32_t turned = limit_q31(state->turned, rs - half, rs + half);
    const int32_t moved  = difference_q31(turned, state->turned);
    state->sign          = (int8_t)bank_q31_sign(moved != 0 ? moved : state->sign);
    state->turned        = turned;
}

static inline void bank_q31_path(const tribo_feedforward_q31_params_t *params,
                                 tribo_feedforward_q31_state_t        *state,
                                 int32_t                               moved,
                                 int32_t                               ahead)
{
    int32_t *const behind = state->behind;
    behind[0]             = first_order_q31_step(difference_q31(behind[0], moved), ahead, params->lag_part);
    behind[1]             = first_order_q31_step(difference_q31(behind[1], moved), behind[0], params->sensor_part);
}

/// Q58, within +-16.
static inline int64_t bank_q31_partial(const tribo_feedforward_q31_state_t *state)
{
    const int32_t *const use = state->learned.use;
    int64_t              sum = 0;
#pragma GCC unroll 4
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        sum += tribo_q31_multiply(use[j + 1u], state->stop[j]);
    }
    return sum;
}

/// G, from the level without doubt.
static inline uint32_t bank_q31_level(const tribo_feedforward_q31_params_t  *params,
                                      const tribo_feedforward_weights_q31_t *learned,
                                      uint32_t                               level)
{
    return bank_q31_share(level, ~tribo_q31_high(params->distrust, learned->doubt));
}

/// f(sigma), within +-FS.
static inline int32_t bank_q31_friction(const tribo_feedforward_q31_params_t  *params,
                                        const tribo_feedforward_weights_q31_t *learned,
                                        uint32_t                               level,
                                        int64_t                                partial,
                                        int32_t                                sigma)
{
    const int64_t sum  = tribo_q31_shift_to_zero(partial + tribo_q31_multiply(learned->use[0], sigma), 29); // Q29
    const int32_t most = sum < 0 ? -INT32_MAX : INT32_MAX;
    const int32_t size =
        (int32_t)sum == sum ? (int32_t)sum : most; // GCOVR_EXCL_BR_LINE: unit.feedforward_q31 goes beyond
    return bank_q31_times(size, bank_q31_level(params, learned, level), 29, (uint32_t)BANK_Q31_ONE);
}

/// f(1) - f(0), within +-FS.
static inline int32_t bank_q31_rise(const tribo_feedforward_q31_params_t  *params,
                                    const tribo_feedforward_weights_q31_t *learned,
                                    uint32_t                               level)
{
    return bank_q31_times(learned->use[0], bank_q31_level(params, learned, level), 29, (uint32_t)BANK_Q31_ONE);
}

#endif
