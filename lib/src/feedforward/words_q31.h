// The operations in which reference.h, tick.h and sensorless.h are written, in fixed point. They add to those of
// number/words_q31.h. words_f32.h defines the same names in single precision.
//
//     force in the loop                       Q31 of full scale FS
//     force in the state, travel              Q29 of FS, within 4 FS
//     noise and rate, which are slow means    Q35 of FS
//     number, a travel in widths              Q29, within 4
//     part                                    Q32
//     gain                                    Q16
//
// Products are rounded towards zero and low passes to nearest, so mirrored inputs give mirrored results. Sums saturate,
// but only if the state is corrupt.

#ifndef TRIBO_FEEDFORWARD_WORDS_Q31_H
#define TRIBO_FEEDFORWARD_WORDS_Q31_H

#include "tribo/feedforward_q31.h"

#include "../friction/law_q31.h"
#include "../number/first_order_q31.h"
#include "../number/ieee_f32.h"
#include "../number/words_q31.h"

#include <stddef.h>

#define CREDIBLE_N INT32_MAX

#define WORDS_ONE (INT32_C(1) << 29) // FS, or 1
#define NUMBER(x) ((int32_t)((x) * 536870912.0 + 0.5))
#define PART(x)   ((uint32_t)((x) * 4294967296.0 + 0.5))
#define GAIN(x)   ((uint32_t)((x) * 65536.0 + 0.5))

typedef int32_t  number_t;
typedef uint32_t part_t;
typedef uint32_t gain_t;

typedef tribo_friction_q31_params_t friction_params_t;

/// Configured breakaway at a force.
typedef struct
{
    force_t L;    ///< half of the jump of friction at a reversal, up to FS
    force_t load; ///< D, the part that does not reverse, less gravity, within FS
} prior_t;

static inline bool is_credible(force_t x, force_t most)
{
    return tribo_q31_magnitude(x) <= (uint32_t)most || most == INT32_MAX;
}

/// `size` with the sign of x. 2^31 becomes INT32_MIN.
static inline force_t signed_as(force_t x, uint32_t size)
{
    return (force_t)(x < 0 ? 0u - size : size);
}

/// A product / 2^shift, at most 2^bits - 1, with the sign of x. One comparison of the high word finds what is larger.
static inline force_t narrowed(force_t x, uint64_t product, uint32_t shift, uint32_t bits)
{
    const uint32_t high = (uint32_t)(product >> 32);
    const uint32_t size = high << (32u - shift) | (uint32_t)product >> shift;
    return signed_as(x, high >> (bits + shift - 32u) > 0u ? (UINT32_C(1) << bits) - 1u : size);
}

static inline force_t clamp_of(force_t x, force_t most)
{
    return limit_q31(x, -most, most);
}

static inline force_t times(force_t x, number_t by)
{
    return narrowed(x ^ by, tribo_q31_product(tribo_q31_magnitude(x), tribo_q31_magnitude(by)), 29, 31);
}

static inline force_t part_of(force_t x, part_t part)
{
    return part_of_q31(x, part);
}

static inline force_t gained(force_t x, gain_t gain)
{
    return narrowed(x, tribo_q31_product(tribo_q31_magnitude(x), gain), 16, 30);
}

static inline number_t over(force_t a, force_t b)
{
    return signed_as(a, ratio_q31(tribo_q31_magnitude(a), (uint32_t)b) >> 2);
}

/// Rounds the step to nearest, but moves by at least one unit, so that x reaches its input. x stays on its side of the
/// input, so the sum fits.
static inline force_t low_pass(force_t x, force_t input, part_t part)
{
    const force_t  left = minus(input, x);
    const uint32_t by   = (uint32_t)((tribo_q31_product(tribo_q31_magnitude(left), part) + 0x80000000u) >> 32);
    return sum_q31(x, signed_as(left, by > 0u ? by : left != 0));
}

/// Limits a sum to the range of the state, so that further sums with it do not saturate.
static inline force_t bounded(force_t x)
{
    return exceeds_q31(x, WORDS_ONE - 1) ? signed_as(x, WORDS_ONE - 1) : x;
}

/// From Q29 to Q35, limited to what fits, and back.
static inline force_t finer(force_t x)
{
    return limit_q31(x, -(WORDS_ONE >> 7), WORDS_ONE >> 7) * 64;
}

static inline force_t coarser(force_t x)
{
    return x / 64;
}

/// From Q31 of the loop to Q29 of the state and back.
static inline force_t inside(force_t x)
{
    return x / 4;
}

static inline force_t outside(force_t x)
{
    return 4 * bounded(x);
}

static inline uint32_t bits_of(force_t x)
{
    return (uint32_t)x;
}

static inline wide_t added(wide_t sum, force_t x)
{
    return (wide_t)((uint64_t)sum + (uint64_t)x);
}

static inline prior_t prior_of(const friction_params_t *friction, force_t force)
{
    const uint32_t load = tribo_q31_magnitude(outside(force));

    uint32_t both[2] = {friction_q31_affine(&friction->law[0], load), friction_q31_affine(&friction->law[1], load)};
    if (!friction->is_shallow)
    {
        tribo_friction_q31_look_up(friction, load, both);
    }
    const force_t half = ((int32_t)both[0] - (int32_t)both[1]) / 8;
    return (prior_t){.L = (force_t)((both[0] + both[1]) / 8u), .load = bounded(half - inside(friction->gravity))};
}

// --- conversions for the learner and the loop's structs --------------------------------------------------------------

static inline float newtons(const tribo_feedforward_learning_t *learning, force_t x)
{
    return (float)x * learning->unit_n;
}

static inline float newtons_of_sum(const tribo_feedforward_learning_t *learning, wide_t x)
{
    return (float)x * learning->unit_n;
}

/// x in Q29, limited to +-3.9.
static inline number_t number_of(float x)
{
    return (number_t)(bound_f32(x, 3.9f) * 536870912.0f);
}

/// x in Q32, limited to 0 and 1 - 2^-24.
static inline part_t part_from(float x)
{
    return (part_t)(limit_f32(x, 0.0f, 0.99999994f) * 4294967296.0f);
}

static inline tribo_feedforward_q31_weights_t taken(const tribo_feedforward_learning_t    *learning,
                                                    const tribo_feedforward_f32_weights_t *learned)
{
    tribo_feedforward_q31_weights_t x = {
        .sliding  = number_of(learned->sliding),
        .constant = number_of(bound_f32(learned->constant / (learning->unit_n * 536870912.0f), 1.0f)),
        .scale    = number_of(learned->scale),
        .trust    = part_from(learned->trust),
        .turned   = number_of(learned->turned),
        .kept     = part_from(learned->kept),
        .fed_back = learned->fed_back};
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_WEIGHTS; j++)
    {
        x.use[j] = number_of(learned->use[j]);
    }
    return x;
}

static inline void show(tribo_force_loop_q31_signals_t *seen, force_t u, force_t F, force_t L, force_t f)
{
    uint32_t      not_counted = 0;
    const int32_t force       = outside(F);

    seen->compensator.force      = force;
    seen->compensator.friction.n = tribo_q31_subtract(outside(u), force, &not_counted);
    seen->compensator.friction.L = outside(L);
    seen->compensator.friction.f = outside(f);
}

#endif
