// Limits in fixed point.

#ifndef TRIBO_LIMIT_Q31_H
#define TRIBO_LIMIT_Q31_H

#include <stdint.h>

/// x within min to max.
static inline int32_t limit_q31(int32_t x, int32_t min, int32_t max)
{
    const int32_t below = x < max ? x : max;
    return below > min ? below : min;
}

// What fits 32 bits unless a state is corrupt: then it wraps, which is defined, and the limits and filters behind it bring it
// back.

static inline int32_t sum_q31(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a + (uint32_t)b);
}

static inline int32_t difference_q31(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a - (uint32_t)b);
}

#endif
