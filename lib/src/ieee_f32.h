// Single precision by IEEE 754, evaluated exactly as written, so that all targets give the same bits. Every f32 source
// includes this file. It refuses a build that would round differently.

#ifndef TRIBO_IEEE_F32_H
#define TRIBO_IEEE_F32_H

#include <float.h>
#include <stdbool.h>
#include <stdint.h>

// -ffast-math may assume that there is no NaN, and every range check here relies on one.
#ifdef __FAST_MATH__
#error "tribo needs IEEE arithmetic: build it without -ffast-math"
#endif

// x87 evaluates in extended precision and rounds when it stores.
#if FLT_EVAL_METHOD != 0
#error "tribo needs float evaluated as float: on 32-bit x86 build it with -msse2 -mfpmath=sse"
#endif

// No fused multiply-add: it rounds once where a product and a sum round twice (tests/identity). GCC ignores the standard's
// pragma and needs its own. Do not build with clang's -ffp-contract=fast: it overrides the pragma silently.
#if defined(__clang__) || !defined(__GNUC__)
#pragma STDC FP_CONTRACT OFF
#else
#pragma GCC optimize("fp-contract=off")
#endif

/// The bits of x: sign (bit 31), exponent (30 to 23), fraction.
static inline uint32_t bits_f32(float x)
{
    const union
    {
        float    value;
        uint32_t bits;
    } same = {.value = x};
    return same.bits;
}

/// The number that has these bits.
static inline float from_bits_f32(uint32_t bits)
{
    const union
    {
        uint32_t bits;
        float    value;
    } same = {.bits = bits};
    return same.value;
}

/// |x|, +0 for -0.
static inline float magnitude(float x)
{
#if defined(__GNUC__) && !defined(TRIBO_PORTABLE_BUILTINS)
    return __builtin_fabsf(x);
#else
    return from_bits_f32(bits_f32(x) & 0x7fffffffu);
#endif
}

/// True when min <= x <= max; false for a NaN.
static inline bool within(float x, float min, float max)
{
    return x >= min && x <= max;
}

/// True for |x| > max and for a NaN: the form in which every range check rejects a NaN.
static inline bool exceeds(float x, float max)
{
    return !(magnitude(x) <= max);
}

/// 1 if a < b, else 0, for finite numbers: the sign bit of a - b. Equal numbers give +0, so 0.
static inline uint32_t less(float a, float b)
{
    return bits_f32(a - b) >> 31;
}

/// Counts an event and stops at UINT32_MAX, so that a counter never returns to 0 by itself.
static inline void count(uint32_t *counter)
{
    const uint32_t next = *counter + 1u;
    if (next != 0u)
    {
        *counter = next;
    }
}

#endif
