// Some code is written once for both arithmetics: compensator.h, guard.h, loop.h and others. It uses the operations and
// names defined here for single precision, and in words_q31.h for fixed point. A source includes the file of its
// arithmetic first, then that code.

#ifndef TRIBO_NUMBER_WORDS_F32_H
#define TRIBO_NUMBER_WORDS_F32_H

#include "ieee_f32.h"

#define NAME(noun, name)  tribo_##noun##_f32_##name
#define INNER(noun, name) noun##_f32_##name ///< a name from a private header
#define OF(member)        member##_n        ///< a member that holds a force
#define TYPED(member)     member##_f32      ///< a member that each arithmetic has of its own

typedef float force_t; ///< N
typedef float wide_t;  ///< a sum or a product that needs more than 32 bits in Q31
typedef float fade_t;  ///< a guard's factor on friction, 0 to 1

#define ALL 1.0f ///< the fade_t that leaves all friction

static inline force_t plus(force_t a, force_t b)
{
    return a + b;
}

static inline force_t minus(force_t a, force_t b)
{
    return a - b;
}

static inline force_t size_of(force_t x)
{
    return magnitude(x);
}

static inline force_t narrow(wide_t x)
{
    return x;
}

static inline bool beyond(force_t x, force_t most)
{
    return exceeds(x, most);
}

static inline force_t within_of(force_t x, force_t low, force_t high)
{
    return limit_f32(x, low, high);
}

static inline force_t faded_by(force_t f, fade_t fade)
{
    return f * fade;
}

/// The fade of the next tick, up or down by `step`.
static inline fade_t next_fade(fade_t fade, fade_t step, bool up)
{
    return limit_f32(fade + (up ? step : -step), 0.0f, 1.0f);
}

static inline void count_one(uint32_t *counter)
{
    count(counter);
}

#endif
