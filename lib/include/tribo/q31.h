/// Fixed point of the _q31 modules.
///
/// A force is a fraction of a full scale, 2^31, which the caller fixes in newtons. The modules saturate a larger result
/// and count it. A reference or a reading at a limit of the scale, +-(2^31 - 1) or INT32_MIN, is a bad input for any
/// input_max, because a saturated converter delivers these values. Pass INT32_MIN for a reading that is not a number.
/// Values whose magnitude is needed stay within -(2^31 - 1) to 2^31 - 1; other values may be INT32_MIN. Products are
/// computed from magnitudes and the sign is put back, so that mirrored inputs give mirrored results. Products are 64
/// bits wide, divisions 32. Right shifts of negative numbers must be arithmetic, and casts to a narrower type must keep
/// the low bits; with other compilers this header does not compile.

#ifndef TRIBO_Q31_H
#define TRIBO_Q31_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TRIBO_Q31_MAX INT32_MAX

/// A constant: `value` as a fraction of `full_scale`, for example TRIBO_Q31(0.5, 2.0) for 0.5 N at a full scale of 2 N.
/// |value| must be less than full_scale.
#define TRIBO_Q31(value, full_scale) ((int32_t)((double)(value) / (double)(full_scale) * 2147483647.0))

typedef char tribo_q31_needs_arithmetic_shifts[((-3) >> 1) == -2 ? 1 : -1];
typedef char tribo_q31_needs_wrapping_casts[(int32_t)UINT32_MAX == -1 ? 1 : -1];

/// Adds 1; stops at UINT32_MAX.
static inline void tribo_q31_count(uint32_t *counter)
{
    const uint32_t next = *counter + 1u;
    if (next != 0u)
    {
        *counter = next;
    }
}

/// The largest or the smallest number of 32 bits, by the sign of x.
static inline int32_t tribo_q31_extreme(int32_t x)
{
    return INT32_MAX ^ (x >> 31); // cppcheck-suppress shiftTooManyBitsSigned
}

/// Counts an overflow towards the sign of x and returns the largest or smallest number.
static inline int32_t tribo_q31_beyond(int32_t x, uint32_t *saturated)
{
    tribo_q31_count(saturated);
    return tribo_q31_extreme(x);
}

/// x within the symmetric range, -(2^31 - 1) to 2^31 - 1; a saturation is counted. The | 1 turns INT32_MIN into -(2^31
/// - 1).
static inline int32_t tribo_q31_saturate(int64_t x, uint32_t *saturated)
{
    const int32_t result = (int32_t)x;
    if (result != x || result == INT32_MIN)
    {
        return tribo_q31_beyond((int32_t)(x >> 32), saturated) | 1; // cppcheck-suppress shiftNegativeLHS
    }
    return result;
}

// a + b and a - b in 32 bits, wrapped, and whether they overflow. Where the processor has a flag for that the
// compiler's builtin takes two instructions; elsewhere ISO C is as short: an overflowed sum has the sign of neither.

#if defined(__GNUC__) && !defined(__ARM_ARCH_6M__) && !defined(__riscv) && !defined(TRIBO_PORTABLE_BUILTINS)

/// a + b, wrapped; returns whether it overflows.
static inline bool tribo_q31_sum_overflows(int32_t a, int32_t b, int32_t *sum)
{
    return __builtin_add_overflow(a, b, sum);
}

/// a - b, wrapped; returns whether it overflows.
static inline bool tribo_q31_difference_overflows(int32_t a, int32_t b, int32_t *difference)
{
    return __builtin_sub_overflow(a, b, difference);
}

#else

/// a + b, wrapped; returns whether it overflows.
static inline bool tribo_q31_sum_overflows(int32_t a, int32_t b, int32_t *sum)
{
    *sum = (int32_t)((uint32_t)a + (uint32_t)b);
    return ((a ^ *sum) & (b ^ *sum)) < 0;
}

/// a - b, wrapped; returns whether it overflows.
static inline bool tribo_q31_difference_overflows(int32_t a, int32_t b, int32_t *difference)
{
    *difference = (int32_t)((uint32_t)a - (uint32_t)b);
    return ((a ^ b) & (a ^ *difference)) < 0;
}

#endif

/// a + b within 32 bits, saturated and counted: for values whose magnitude is not needed.
static inline int32_t tribo_q31_add(int32_t a, int32_t b, uint32_t *saturated)
{
    int32_t sum;
    if (tribo_q31_sum_overflows(a, b, &sum))
    {
        return tribo_q31_beyond(a, saturated);
    }
    return sum;
}

/// a - b within 32 bits, saturated and counted: for values whose magnitude is not needed.
static inline int32_t tribo_q31_subtract(int32_t a, int32_t b, uint32_t *saturated)
{
    int32_t difference;
    if (tribo_q31_difference_overflows(a, b, &difference))
    {
        return tribo_q31_beyond(a, saturated);
    }
    return difference;
}

/// x / 2^shift, rounded down, within 32 bits, saturated and counted. `shift` 1 to 31. A result fits if the high word is
/// from -2^(shift - 1) to 2^(shift - 1) - 1: one comparison.
static inline int32_t tribo_q31_narrow(int64_t x, uint32_t shift, uint32_t *saturated)
{
    const int32_t  high = (int32_t)(x >> 32);
    const uint32_t half = UINT32_C(1) << (shift - 1u);
    if ((uint32_t)high + half >= 2u * half)
    {
        return tribo_q31_beyond(high, saturated);
    }
    return (int32_t)((uint32_t)high << (32u - shift) | (uint32_t)x >> shift);
}

/// x 2^shift in 64 bits, from two shifts of 32. `shift` 0 to 31.
static inline int64_t tribo_q31_lift(int32_t x, uint32_t shift)
{
    const uint32_t high = (uint32_t)(x >> 1 >> (31u - shift));
    return (int64_t)((uint64_t)high << 32 | (uint32_t)x << shift);
}

/// x 2^shift within 32 bits, saturated and counted. `shift` 0 to 31.
static inline int32_t tribo_q31_widen(int32_t x, uint32_t shift, uint32_t *saturated)
{
    const int32_t result = (int32_t)((uint32_t)x << shift);
    if (result >> shift != x) // cppcheck-suppress [shiftTooManyBitsSigned, integerOverflow]
    {
        return tribo_q31_beyond(x, saturated);
    }
    return result;
}

/// |x|; INT32_MIN gives 2^31.
static inline uint32_t tribo_q31_magnitude(int32_t x)
{
    const uint32_t sign = 0u - (uint32_t)(x < 0);
    return ((uint32_t)x ^ sign) - sign;
}

#if defined(__ARM_ARCH_6M__) && !defined(TRIBO_Q31_SHORT_PRODUCTS)
#define TRIBO_Q31_SHORT_PRODUCTS // there is no long multiplication
#endif

#ifndef TRIBO_Q31_SHORT_PRODUCTS

/// a b, unsigned.
static inline uint64_t tribo_q31_product(uint32_t a, uint32_t b)
{
    return (uint64_t)a * b;
}

/// a b, signed.
static inline int64_t tribo_q31_multiply(int32_t a, int32_t b)
{
    return (int64_t)a * b;
}

#else // four products of 16 bits take half the time of the compiler's helper

#ifdef __ARM_ARCH_6M__ // calls: measured to be shorter and to take less stack than inline products
#define TRIBO_Q31_PRODUCT __attribute__((noinline, unused)) static
#else
#define TRIBO_Q31_PRODUCT static inline
#endif

TRIBO_Q31_PRODUCT uint64_t tribo_q31_product(uint32_t a, uint32_t b)
{
    const uint32_t low    = (a & 0xffffu) * (b & 0xffffu);
    const uint32_t first  = (a >> 16) * (b & 0xffffu) + (low >> 16); // below 2^32
    const uint32_t second = (a & 0xffffu) * (b >> 16) + (first & 0xffffu);
    const uint32_t high   = (a >> 16) * (b >> 16) + (first >> 16) + (second >> 16);
    return (uint64_t)high << 32 | (second << 16 | (low & 0xffffu));
}

/// a b, signed, with signed upper halves; `first` and `second` are within -2^31 to 2^31 - 1.
TRIBO_Q31_PRODUCT int64_t tribo_q31_multiply(int32_t a, int32_t b)
{
    const int32_t  a_low  = a & 0xffff;
    const int32_t  b_low  = b & 0xffff;
    const uint32_t low    = (uint32_t)a_low * (uint32_t)b_low;
    const int32_t  first  = (a >> 16) * b_low + (int32_t)(low >> 16);             // cppcheck-suppress shiftNegativeLHS
    const int32_t  second = a_low * (b >> 16) + (first & 0xffff);                 // cppcheck-suppress shiftNegativeLHS
    const int32_t  high = (a >> 16) * (b >> 16) + (first >> 16) + (second >> 16); // cppcheck-suppress shiftNegativeLHS
    return (int64_t)((uint64_t)(uint32_t)high << 32 | ((uint32_t)second << 16 | (low & 0xffffu)));
}

#undef TRIBO_Q31_PRODUCT

#endif

/// The upper word of a b.
static inline uint32_t tribo_q31_high(uint32_t a, uint32_t b)
{
    return (uint32_t)(tribo_q31_product(a, b) >> 32);
}

/// x / 2^shift, rounded down, `shift` 0 to 31: half the cost of a 64-bit shift by up to 63 on 32-bit targets.
static inline int64_t tribo_q31_shift(int64_t x, uint32_t shift)
{
    const int32_t  high  = (int32_t)(x >> 32);
    const uint32_t moved = ((uint32_t)high * 2u) << (31u - shift);
    // cppcheck-suppress shiftTooManyBitsSigned
    return (int64_t)((uint64_t)(uint32_t)(high >> shift) << 32 | (moved | (uint32_t)x >> shift));
}

/// Added to x, makes x / 2^shift, rounded down, round towards zero: 2^shift - 1 for a negative x, else 0. `shift` 0 to
/// 31.
static inline int64_t tribo_q31_up(int64_t x, uint32_t shift)
{
    const uint32_t ones = (uint32_t)((int32_t)(x >> 32) >> 31); // cppcheck-suppress shiftTooManyBitsSigned
    return ones >> 1 >> (31u - shift);
}

/// x / 2^shift towards zero, so that decaying values reach zero from both sides. `shift` 0 to 31.
static inline int64_t tribo_q31_shift_to_zero(int64_t x, uint32_t shift)
{
    return tribo_q31_shift(x + tribo_q31_up(x, shift), shift);
}

/// Leading zeros of x, which is not 0.
static inline uint32_t tribo_q31_leading_zeros(uint32_t x)
{
#if defined(__GNUC__) && !defined(TRIBO_PORTABLE_BUILTINS)
    return (uint32_t)__builtin_clz(x);
#else
    uint32_t zeros = 0;
    uint32_t rest  = x;
    for (uint32_t half = 16; half > 0u; half /= 2u)
    {
        const uint32_t empty = rest >> (32u - half) == 0u ? half : 0u;
        rest <<= empty;
        zeros += empty;
    }
    return zeros;
#endif
}

/// 2^63 / m or a little less, for m from 2^31: within 2 in the last place of 2^-29 relative.
/// One division of 32 bits for 16 bits of 1/m, and one Newton step for the rest.
static inline uint32_t tribo_q31_inverse(uint32_t m)
{
    const uint32_t coarse = UINT32_MAX / (m >> 16);                                 // 2^48 / m
    const int32_t  error  = (int32_t)(uint32_t)(tribo_q31_product(m, coarse) >> 4); // (m coarse - 2^48) / 16
    const int32_t  step   = (int32_t)(tribo_q31_multiply((int32_t)(coarse << 14), error) >> 32) >> 11;
    return (coarse << 15) - (uint32_t)step - 1u; // it fits
}

/// a / b in Q31, for a below b, as exact as the inverse.
static inline uint32_t tribo_q31_ratio(uint32_t a, uint32_t b)
{
    const uint32_t zeros = tribo_q31_leading_zeros(b);
    return tribo_q31_high(a << zeros, tribo_q31_inverse(b << zeros));
}

#ifdef __cplusplus
}
#endif

#endif
