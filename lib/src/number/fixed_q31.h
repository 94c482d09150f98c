// Converts physical parameters from float to fixed point, for the set-up of the _q31 modules. No tick calls these
// functions.
//
// Every parameter is first accepted by its f32 module, so the values here are finite and in range. All scaling is by
// powers of two, which is exact in float; each number is then rounded once, to nearest. The numbers that run are
// therefore within half a unit in the last place of the design. Stability and headroom are checked on them.

#ifndef TRIBO_NUMBER_FIXED_Q31_H
#define TRIBO_NUMBER_FIXED_Q31_H

#include "tribo/q31.h"
#include "tribo/status.h"

#include "ieee_f32.h"

#define FIXED_Q31_SMALLEST 1.0e-6f     // as a fraction of full scale or of 1: below it less than 11 bits are left
#define FIXED_Q31_FULL     0.99999994f // the largest float below full scale, which itself does not fit

/// x 2^bits for `bits` of either sign. Exact except for overflow and underflow.
static inline float scaled(float x, int32_t bits)
{
    float y = x;
    for (int32_t i = 0; i < bits; i++)
    {
        y *= 2.0f;
    }
    for (int32_t i = bits; i < 0; i++)
    {
        y *= 0.5f;
    }
    return y;
}

/// x 2^bits rounded to nearest, for |x 2^bits| < 2^31.
static inline int32_t fixed(float x, int32_t bits)
{
    const float y = scaled(x, bits);
    if (magnitude(y) >= 8388608.0f)
    {
        return (int32_t)y; // a float of 2^23 or more is an integer; adding 0.5 could change it
    }
    return (int32_t)(y < 0.0f ? y - 0.5f : y + 0.5f);
}

/// x 2^bits rounded to nearest, for x >= 0. A result of 2^32 or more becomes UINT32_MAX.
static inline uint32_t fixed_unsigned(float x, int32_t bits)
{
    const float y = scaled(x, bits);
    if (y >= 8388608.0f)
    {
        return y < 4294967296.0f ? (uint32_t)y : UINT32_MAX;
    }
    return (uint32_t)(y + 0.5f);
}

/// A force of at most full scale in Q31. Full scale itself, 2^31, does not fit and becomes 2^31 - 1 with the sign of
/// the force.
static inline int32_t fixed_force(float force_n, float full_scale_n)
{
    const float part = force_n / full_scale_n;
    return magnitude(part) < 1.0f ? fixed(part, 31) : (part < 0.0f ? -TRIBO_Q31_MAX : TRIBO_Q31_MAX);
}

/// The largest credible |r| and |y|. It is below the limits of the scale, because an input beyond the scale is stored
/// as its limit.
static inline int32_t fixed_input_max(float input_max_n, float full_scale_n)
{
    const int32_t most = fixed_force(input_max_n, full_scale_n);
    return most < TRIBO_Q31_MAX ? most : TRIBO_Q31_MAX - 1;
}

// The feed-forward holds forces in units of 2^-29 full scales.

/// A force in units of 2^-29 full scales. Forces up to 4 full scales fit.
static inline int32_t units(float force_n, float full_scale_n)
{
    return fixed_force(force_n / 4.0f, full_scale_n);
}

/// True if a force is large enough to keep its bits and small enough to leave headroom for sums.
static inline bool fits(float force_n, float full_scale_n)
{
    return within(force_n / full_scale_n, FIXED_Q31_SMALLEST, 0.25f);
}

#endif
