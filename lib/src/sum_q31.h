// Sums of products in 64 bits, which wrap. With Thumb-2 an instruction each: gcc makes up to four, and other ones in every
// other function.

#ifndef TRIBO_SUM_Q31_H
#define TRIBO_SUM_Q31_H

#include "tribo/q31.h"

#include "pair.h"
#include "usual.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef TRIBO_THUMB2

#ifdef __ARM_FEATURE_DSP
#define SUM_Q31_ADDS_BY_ONE // an accumulate takes a cycle, a sum of two words two: not so on the M3
#endif

/// Two's complement, in words, as gcc keeps 64 bits in neighbouring registers and copies them there.
typedef struct
{
    uint32_t low, high;
} sum_q31_t;

static inline sum_q31_t sum_q31_of(uint32_t low, uint32_t high)
{
    return (sum_q31_t){.low = low, .high = high};
}

static inline uint32_t sum_q31_low(sum_q31_t sum)
{
    return sum.low;
}

static inline uint32_t sum_q31_high(sum_q31_t sum)
{
    return sum.high;
}

static inline sum_q31_t sum_q31_load(const int64_t *from)
{
    const pair_t words = pair_load(from);
    return sum_q31_of((uint32_t)words.first, (uint32_t)words.second);
}

static inline void sum_q31_store(int64_t *to, sum_q31_t sum)
{
    __asm__("strd %1, %2, %0" : "=m"(*to) : "r"(sum.low), "r"(sum.high));
}

/// sum + a b
static inline sum_q31_t sum_q31_accumulate(sum_q31_t sum, int32_t a, int32_t b)
{
    uint32_t low  = sum.low;
    uint32_t high = sum.high;
    __asm__("smlal %0, %1, %2, %3" : "+r"(low), "+r"(high) : "r"(a), "r"(b));
    return sum_q31_of(low, high);
}

/// In the registers that it shall be in here and there, so that it is not moved about in between. (Variables around the
/// registers': nothing that a sanitizer makes a call of may come between those.)
static inline sum_q31_t sum_q31_settle(sum_q31_t sum)
{
    uint32_t          low              = sum.low;
    uint32_t          high             = sum.high;
    register uint32_t ip __asm__("ip") = low;
    register uint32_t lr __asm__("lr") = high;
    __asm__("" : "+r"(ip), "+r"(lr));
    low  = ip;
    high = lr;
    return sum_q31_of(low, high);
}

#else

typedef uint64_t sum_q31_t;

static inline sum_q31_t sum_q31_of(uint32_t low, uint32_t high)
{
    return (uint64_t)high << 32 | low;
}

static inline uint32_t sum_q31_low(sum_q31_t sum)
{
    return (uint32_t)sum;
}

static inline uint32_t sum_q31_high(sum_q31_t sum)
{
    return (uint32_t)(sum >> 32);
}

static inline sum_q31_t sum_q31_load(const int64_t *from)
{
    return (uint64_t)*from;
}

static inline void sum_q31_store(int64_t *to, sum_q31_t sum)
{
    *to = (int64_t)sum;
}

static inline sum_q31_t sum_q31_accumulate(sum_q31_t sum, int32_t a, int32_t b)
{
    return sum + (uint64_t)tribo_q31_multiply(a, b);
}

static inline sum_q31_t sum_q31_settle(sum_q31_t sum)
{
    return sum;
}

#endif

/// The sum 2^-fraction, rounded down, does not fit 32 bits. `fraction` 1 to 31, a constant.
static inline bool sum_q31_is_beyond(sum_q31_t sum, uint32_t fraction)
{
    const uint32_t half = UINT32_C(1) << (fraction - 1u);
    return TRIBO_RARE(sum_q31_high(sum) + half >= 2u * half);
}

/// 1, for the functions below, that it is made once for all of them.
static inline int32_t sum_q31_one(void)
{
    return tribo_q31_opaque(1);
}

/// sum + x, from two words
static inline sum_q31_t sum_q31_add_words(sum_q31_t sum, uint32_t low, uint32_t high)
{
    const uint64_t x = (uint64_t)high << 32 | low;
    const uint64_t s = ((uint64_t)sum_q31_high(sum) << 32 | sum_q31_low(sum)) + x;
    return sum_q31_of((uint32_t)s, (uint32_t)(s >> 32));
}

/// sum + x
static inline sum_q31_t sum_q31_add_signed(sum_q31_t sum, int32_t x, int32_t one)
{
#ifdef SUM_Q31_ADDS_BY_ONE
    return sum_q31_accumulate(sum, x, one);
#else
    (void)one;
    return sum_q31_add_words(sum, (uint32_t)x, (uint32_t)-(int32_t)(x < 0));
#endif
}

/// sum + x
static inline sum_q31_t sum_q31_add(sum_q31_t sum, uint32_t x, int32_t one)
{
#ifdef SUM_Q31_ADDS_BY_ONE
    uint32_t low  = sum.low;
    uint32_t high = sum.high;
    __asm__("umlal %0, %1, %2, %3" : "+r"(low), "+r"(high) : "r"(x), "r"(one));
    return sum_q31_of(low, high);
#else
    (void)one;
    return sum_q31_add_words(sum, x, 0);
#endif
}

/// sum + x 2^-shift, rounded down, |x| below 2^61. `power_shift` is 2^(30 - shift), and a word whose low byte is shift, 0 to
/// 30: with Thumb-2 that takes half of what shifts of 64 bits do.
static inline sum_q31_t sum_q31_add_shifted(sum_q31_t sum, sum_q31_t x, pair_t power_shift, int32_t one)
{
#ifdef TRIBO_THUMB2
    uint32_t low;
    __asm__("lsr %0, %1, %2" : "=r"(low) : "r"(x.low), "r"(power_shift.second));
    return sum_q31_accumulate(sum_q31_add(sum, low, one), (int32_t)(x.high << 2), power_shift.first);
#else
    (void)one;
    return sum + (uint64_t)tribo_q31_shift((int64_t)x, (uint32_t)power_shift.second & 0xffu);
#endif
}

#endif
