// From float to fixed point, for the set-up of the _q31 modules. Not for a step.

#ifndef TRIBO_FIXED_Q31_H
#define TRIBO_FIXED_Q31_H

#include "tribo/force_f32.h"
#include "tribo/q31.h"

#include "ieee_f32.h"

#define FIXED_Q31_SMALLEST 1.0e-6f     // of full scale, or of 1: what is smaller has too few bits, or none
#define FIXED_Q31_FULL     0.99999994f // full scale, which itself does not fit

static inline float larger(float a, float b)
{
    return a > b ? a : b;
}

/// x 2^bits, exact but for overflow and underflow.
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
        return (int32_t)y; // an integer already, and 0.5 more could round it up
    }
    return (int32_t)(y < 0.0f ? y - 0.5f : y + 0.5f);
}

/// x 2^bits rounded to nearest, for x from 0; what is 2^32 or more becomes the largest number.
static inline uint32_t fixed_unsigned(float x, int32_t bits)
{
    const float y = scaled(x, bits);
    if (y >= 8388608.0f)
    {
        return y < 4294967296.0f ? (uint32_t)y : UINT32_MAX;
    }
    return (uint32_t)(y + 0.5f);
}

/// A force within full scale in Q31; full scale itself does not fit and becomes the largest number.
static inline int32_t fixed_force(float force_n, float full_scale_n)
{
    const float part = force_n / full_scale_n;
    return magnitude(part) < 1.0f ? fixed(part, 31) : (part < 0.0f ? -TRIBO_Q31_MAX : TRIBO_Q31_MAX);
}

static inline bool full_scale_ok(float full_scale_n)
{
    return within(full_scale_n, 1.0e-3f, TRIBO_F32_FORCE_MAX_N);
}

#endif
