// The operations in which reference.h, tick.h and sensorless.h are written, in single precision. They add to those of
// number/words_f32.h. words_q31.h defines the same names in fixed point.

#ifndef TRIBO_FEEDFORWARD_WORDS_F32_H
#define TRIBO_FEEDFORWARD_WORDS_F32_H

#include "tribo/feedforward_f32.h"

#include "../friction/law_f32.h"
#include "../number/first_order_f32.h"
#include "../number/words_f32.h"

#include <stddef.h>

#define CREDIBLE_N 1.0e9f // a larger force comes from a corrupt state

#define NUMBER(x) (x##f) // a constant of type number_t, within 4
#define PART(x)   (x##f) // a constant of type part_t, 0 to 1
#define GAIN(x)   (x##f) // a constant of type gain_t

typedef float number_t; ///< has no unit and stays within 4: sigma, stops, weights
typedef float part_t;   ///< 0 to 1
typedef float gain_t;   ///< not negative

typedef tribo_friction_f32_params_t friction_params_t;

/// Configured breakaway at a force.
typedef struct
{
    force_t L;    ///< half of the jump of friction at a reversal
    force_t load; ///< D, the part that does not reverse, less gravity
} prior_t;

/// True if |x| <= most. False for a NaN.
static inline bool is_credible(force_t x, force_t most)
{
    return !exceeds(x, most);
}

/// x limited to +-most, by one comparison while it is inside. A NaN becomes -most.
static inline force_t clamp_of(force_t x, force_t most)
{
    return !exceeds(x, most) ? x : x > 0.0f ? most : -most;
}

static inline force_t times(force_t x, number_t by)
{
    return by * x;
}

static inline force_t part_of(force_t x, part_t part)
{
    return part * x;
}

static inline force_t gained(force_t x, gain_t gain)
{
    return gain * x;
}

/// a/b limited to +-1, for b > 0.
static inline number_t over(force_t a, force_t b)
{
    return bound_f32(a / b, 1.0f);
}

static inline force_t low_pass(force_t x, force_t input, part_t part)
{
    return first_order_f32_step(x, input, part);
}

/// Limits a sum in Q31 so that further sums with it do not saturate. Nothing to do in float.
static inline force_t bounded(force_t x)
{
    return x;
}

/// From a force to the format of noise and rate and back. In Q31 such slow means need more bits.
static inline force_t finer(force_t x)
{
    return x;
}

static inline force_t coarser(force_t x)
{
    return x;
}

/// From a force of the loop to the format of the state and back.
static inline force_t inside(force_t x)
{
    return x;
}

static inline force_t outside(force_t x)
{
    return x;
}

static inline uint32_t bits_of(force_t x)
{
    return bits_f32(x);
}

static inline wide_t added(wide_t sum, force_t x)
{
    return sum + x;
}

static inline prior_t prior_of(const friction_params_t *friction, force_t force)
{
    const float load    = magnitude(force);
    float       both[2] = {friction_f32_affine(&friction->law[0], load), friction_f32_affine(&friction->law[1], load)};
    if (friction->table_length > 0u)
    {
        tribo_friction_f32_look_up(friction, load, both);
    }
    return (prior_t){.L = 0.5f * (both[0] + both[1]), .load = 0.5f * (both[0] - both[1]) - friction->gravity_n};
}

// --- conversions for the learner and the loop's structs --------------------------------------------------------------

static inline float newtons(const tribo_feedforward_learning_t *learning, force_t x)
{
    (void)learning;
    return x;
}

static inline float newtons_of_sum(const tribo_feedforward_learning_t *learning, wide_t x)
{
    (void)learning;
    return x;
}

static inline tribo_feedforward_f32_weights_t taken(const tribo_feedforward_learning_t    *learning,
                                                    const tribo_feedforward_f32_weights_t *learned)
{
    (void)learning;
    return *learned;
}

/// Writes the signals member by member: assigning a struct would call memset.
static inline void show(tribo_force_loop_f32_signals_t *seen, force_t u, force_t F, force_t L, force_t f)
{
    seen->compensator.force_n      = F;
    seen->compensator.friction.n_n = u - F;
    seen->compensator.friction.L_n = L;
    seen->compensator.friction.f_n = f;
}

#endif
