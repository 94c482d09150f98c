// Single precision as IEEE 754 has it, exact as written, so that all targets give the same bits. Every f32 source includes
// this file.

#ifndef TRIBO_IEEE_F32_H
#define TRIBO_IEEE_F32_H

#include <float.h>
#include <stdbool.h>
#include <stdint.h>

#ifdef __FAST_MATH__
#error "tribo needs IEEE arithmetic: build it without -ffast-math"
#endif

#if FLT_EVAL_METHOD != 0
#error "tribo needs float evaluated as float: on 32-bit x86 build it with -msse2 -mfpmath=sse"
#endif

// No fused multiply-add, whatever the language standard or the processor (tests/identity); only clang's
// -ffp-contract=fast is above its pragma, and tells nobody. GCC knows no STDC FP_CONTRACT.
#if defined(__clang__) || !defined(__GNUC__)
#pragma STDC FP_CONTRACT OFF
#else
#pragma GCC optimize("fp-contract=off")
#endif

static inline uint32_t bits_f32(float x)
{
    const union
    {
        float    value;
        uint32_t bits;
    } same = {.value = x};
    return same.bits;
}

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

/// True for |x| > max and for a NaN.
static inline bool exceeds(float x, float max)
{
    return !(magnitude(x) <= max);
}

/// 1 where a < b, else 0, for finite numbers: the sign of the difference, without a branch.
static inline uint32_t less(float a, float b)
{
    return bits_f32(a - b) >> 31;
}

static inline void count(uint32_t *counter)
{
    const uint32_t next = *counter + 1u;
    if (next != 0u)
    {
        *counter = next;
    }
}

#endif
