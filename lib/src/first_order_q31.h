// Products, ratios and first-order low passes in fixed point, rounded towards zero: mirrored inputs give mirrored results, and what
// decays comes to rest.

#ifndef TRIBO_FIRST_ORDER_Q31_H
#define TRIBO_FIRST_ORDER_Q31_H

#include "tribo/q31.h"

#include "limit_q31.h"

/// x part, `part` in Q32.
static inline int32_t part_of_q31(int32_t x, uint32_t part)
{
    const int32_t size = (int32_t)tribo_q31_high(tribo_q31_magnitude(x), part);
    return x < 0 ? -size : size;
}

/// a/b in Q31 for b over 0, a little below 1 where a is not below b.
static inline uint32_t ratio_q31(uint32_t a, uint32_t b)
{
    const uint32_t odd = b | 1u; // not 0, whatever a corrupt state makes of b; and next to b otherwise
    return tribo_q31_ratio(a < odd ? a : odd - 1u, odd);
}

/// The state after a tick of the low pass with `part`, Q32; the difference of the two must fit. It stops short of its input by
/// less than 1/part units.
static inline int32_t first_order_q31_step(int32_t x, int32_t input, uint32_t part)
{
    return sum_q31(x, part_of_q31(difference_q31(input, x), part));
}

#endif
