// Limits in single precision.

#ifndef TRIBO_LIMIT_F32_H
#define TRIBO_LIMIT_F32_H

#include "ieee_f32.h"

/// x within min to max.
static inline float limit_f32(float x, float min, float max)
{
    const float below = x < max ? x : max;
    return below > min ? below : min;
}

/// x within +-max; a NaN becomes max.
static inline float bound_f32(float x, float max)
{
    if (exceeds(x, max))
    {
        return x < 0.0f ? -max : max;
    }
    return x;
}

#endif
