// Single precision by IEEE 754, evaluated exactly as written, so that all targets give the same bits. Every source that
// computes in float includes this file. It refuses a build that would round differently.

#ifndef TRIBO_NUMBER_IEEE_F32_H
#define TRIBO_NUMBER_IEEE_F32_H

#include <float.h>
#include <stdbool.h>
#include <stdint.h>

// -ffinite-math-only (part of -ffast-math and -Ofast) assumes that no NaN occurs; every range check here must catch
// NaNs.
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "tribo needs IEEE arithmetic: build it without -Ofast, -ffast-math and -ffinite-math-only"
#endif

// These are the parts of -funsafe-math-optimizations that change bits and for which gcc defines macros. Those of clang
// are switched off below.
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || defined(__NO_SIGNED_ZEROS__)
#error "tribo needs IEEE arithmetic: build it without -funsafe-math-optimizations and its parts"
#endif

// With 1 and 2 float is evaluated in a wider format and rounded when stored, e.g. on x87. With 16 only _Float16 is
// evaluated in its own format; gcc sets it on processors with half-precision arithmetic (Cortex-M55, AVX512-FP16).
#if FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 16
#error "tribo needs float evaluated as float: build it without -ffp-eval-method, on 32-bit x86 with -msse2 -mfpmath=sse"
#endif

// No fused multiply-add: it rounds once where a product and a sum round twice (tests/identity).
#if defined(__clang__)
#pragma clang fp contract(off) reassociate(off) reciprocal(off)
#if !defined(__wasm__) // WebAssembly has no fused multiply-add, and clang 19 crashes on this pragma
#pragma clang fp exceptions(                                                                                           \
    maytrap) // the only pragma that -ffp-contract=fast respects (clang 19 for AArch64 ignores it, too)
#endif
#if __has_warning("-Wnan-infinity-disabled")
#pragma clang diagnostic push
#pragma clang diagnostic error "-Wnan-infinity-disabled"
typedef char tribo_needs_a_build_without_fno_honor_nans[__builtin_isnan(0.0f) ? -1 : 1];
#pragma clang diagnostic pop
#endif
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off") // gcc ignores the standard's pragma
#else
#pragma STDC FP_CONTRACT OFF
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

/// The number with these bits.
static inline float from_bits_f32(uint32_t bits)
{
    const union
    {
        uint32_t bits;
        float    value;
    } same = {.bits = bits};
    return same.value;
}

/// |x|. The result is +0 for -0.
static inline float magnitude(float x)
{
#if defined(__GNUC__) && !defined(TRIBO_PORTABLE_BUILTINS)
    return __builtin_fabsf(x);
#else
    return from_bits_f32(bits_f32(x) & 0x7fffffffu);
#endif
}

/// True if min <= x <= max; false for a NaN.
static inline bool within(float x, float min, float max)
{
    return x >= min && x <= max;
}

/// True if |x| > max or x is a NaN: the form in which every range check rejects a NaN.
static inline bool exceeds(float x, float max)
{
    return !(magnitude(x) <= max);
}

/// 1 if a < b, otherwise 0, for finite numbers: the sign bit of a - b. Equal numbers give +0, so the result is 0.
static inline uint32_t less(float a, float b)
{
    return bits_f32(a - b) >> 31;
}

/// Counts an event and stops at UINT32_MAX, so that a counter never wraps to 0.
static inline void count(uint32_t *counter)
{
    const uint32_t next = *counter + 1u;
    if (next != 0u)
    {
        *counter = next;
    }
}

/// The larger number; b if one of them is a NaN.
static inline float larger(float a, float b)
{
    return a > b ? a : b;
}

/// x limited to min..max.
static inline float limit_f32(float x, float min, float max)
{
    const float below = x < max ? x : max;
    return below > min ? below : min;
}

/// x limited to +-max. A NaN becomes max.
static inline float bound_f32(float x, float max)
{
    if (exceeds(x, max))
    {
        return x < 0.0f ? -max : max;
    }
    return x;
}

/// sqrt(x), or up to 2e-6 of it more; 0 for x <= 0. Halving the exponent gives a start within 6 %. The two steps of
/// Newton's method that follow approach the root from above.
static inline float root_f32(float x)
{
    float y = from_bits_f32((bits_f32(x) >> 1) + 0x1fc00000u);
    for (uint32_t i = 0; i < 2u && x > 0.0f; i++)
    {
        y = 0.5f * (y + x / y);
    }
    return x > 0.0f ? y : 0.0f;
}

#endif
