// Limits, products, ratios and first-order low passes in fixed point. They round towards zero, so mirrored inputs give
// mirrored results and decaying signals reach zero.

#ifndef TRIBO_NUMBER_FIRST_ORDER_Q31_H
#define TRIBO_NUMBER_FIRST_ORDER_Q31_H

#include "tribo/q31.h"

/// x limited to min..max.
static inline int32_t limit_q31(int32_t x, int32_t min, int32_t max)
{
    const int32_t below = x < max ? x : max;
    return below > min ? below : min;
}

/// True if |x| > max >= 0. Otherwise x + max is within 0 to 2 max, and 2 max fits an unsigned number.
static inline bool exceeds_q31(int32_t x, int32_t max)
{
    return (uint32_t)x + (uint32_t)max > 2u * (uint32_t)max;
}

// These sums fit 32 bits unless a state is corrupt. Then they wrap, which is defined because they are unsigned, and the
// limits and filters after them recover.

static inline int32_t sum_q31(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a + (uint32_t)b);
}

static inline int32_t difference_q31(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a - (uint32_t)b);
}

/// x times `part`, which is Q32.
static inline int32_t part_of_q31(int32_t x, uint32_t part)
{
    const int32_t size = (int32_t)tribo_q31_high(tribo_q31_magnitude(x), part);
    return x < 0 ? -size : size;
}

/// a/b in Q31 for b > 0. The result is just below 1 if a >= b.
static inline uint32_t ratio_q31(uint32_t a, uint32_t b)
{
    const uint32_t odd = b | 1u; // never 0, even in a corrupt state; otherwise within 1 of b
    return tribo_q31_ratio(a < odd ? a : odd - 1u, odd);
}

/// The state after a tick of the low pass with `part`, which is Q32. The difference of input and x must fit 32 bits.
/// The state stops short of its input by less than 1/part units.
static inline int32_t first_order_q31_step(int32_t x, int32_t input, uint32_t part)
{
    return sum_q31(x, part_of_q31(difference_q31(input, x), part));
}

#endif
