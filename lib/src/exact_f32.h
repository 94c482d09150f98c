// Included by every f32 source: makes the arithmetic exact as written, so that all targets give the same bits.

#ifndef TRIBO_EXACT_F32_H
#define TRIBO_EXACT_F32_H

#include "usual.h"

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

/// Integers in the order of |x|, a NaN above all: one compare serves both, and this shift is free on Arm.
static inline uint32_t order_f32(float x)
{
    return bits_f32(x) << 1;
}

/// True for a NaN and for |x| > max.
static inline bool exceeds(float x, float max)
{
    return order_f32(x) > order_f32(max);
}

static inline void count(uint32_t *counter)
{
    const uint32_t next = *counter + 1u;
    if (next != 0u)
    {
        *counter = next;
    }
}

/// True when min <= x <= max; false for a NaN.
static inline bool within(float x, float min, float max)
{
    return x >= min && x <= max;
}

static inline float magnitude(float x)
{
#ifdef __GNUC__
    return __builtin_fabsf(x); // one instruction, with an FPU or without
#else
    return x < 0.0f ? -x : x;
#endif
}

#endif
