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

#endif
