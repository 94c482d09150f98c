// The operations and names of words_f32.h in fixed point. Sums saturate.

#ifndef TRIBO_NUMBER_WORDS_Q31_H
#define TRIBO_NUMBER_WORDS_Q31_H

#include "tribo/q31.h"

#include "first_order_q31.h"

#if defined(__GNUC__) && defined(__ARM_FEATURE_DSP) && !defined(TRIBO_PORTABLE_BUILTINS)
#define SATURATING_INSTRUCTIONS // a sum or a difference is one instruction, with the same result
#include <arm_acle.h>
#endif

#define NAME(noun, name)  tribo_##noun##_q31_##name
#define INNER(noun, name) noun##_q31_##name
#define OF(member)        member
#define TYPED(member)     member##_q31

typedef int32_t  force_t; ///< Q31
typedef int64_t  wide_t;  ///< a sum or a product that needs more than 32 bits
typedef uint32_t fade_t;  ///< Q32

#define ALL UINT32_MAX

#ifdef SATURATING_INSTRUCTIONS

static inline force_t plus(force_t a, force_t b)
{
    return __qadd(a, b);
}

static inline force_t minus(force_t a, force_t b)
{
    return __qsub(a, b);
}

#else

static inline force_t plus(force_t a, force_t b)
{
    uint32_t not_counted = 0;
    return tribo_q31_add(a, b, &not_counted);
}

static inline force_t minus(force_t a, force_t b)
{
    uint32_t not_counted = 0;
    return tribo_q31_subtract(a, b, &not_counted);
}

#endif

static inline force_t size_of(force_t x)
{
    const uint32_t size = tribo_q31_magnitude(x);
    return size < (uint32_t)INT32_MAX ? (force_t)size : INT32_MAX;
}

static inline force_t narrow(wide_t x)
{
    uint32_t not_counted = 0;
    return tribo_q31_saturate(x, &not_counted);
}

static inline bool beyond(force_t x, force_t most)
{
    return exceeds_q31(x, most);
}

static inline force_t within_of(force_t x, force_t low, force_t high)
{
    return limit_q31(x, low, high);
}

static inline force_t faded_by(force_t f, fade_t fade)
{
    return fade != UINT32_MAX ? part_of_q31(f, fade) : f;
}

static inline fade_t next_fade(fade_t fade, fade_t step, bool up)
{
    const fade_t room = up ? ~fade : fade;
    const fade_t by   = step < room ? step : room;
    return up ? fade + by : fade - by;
}

static inline void count_one(uint32_t *counter)
{
    tribo_q31_count(counter);
}

#endif
