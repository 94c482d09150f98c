// Forces in units of 2^-29 full scales, for the set-up of the feed-forward's _q31 modules.

#ifndef TRIBO_UNITS_Q31_H
#define TRIBO_UNITS_Q31_H

#include "fixed_q31.h"

#define UNITS_Q31_PART_MIN 1.0e-5f // of a low pass: 1e5 units are left of its way

/// A force in units, 2^29 of which are full scale; forces up to 4 full scales fit.
static inline int32_t units(float force_n, float full_scale_n)
{
    return fixed_force(force_n / 4.0f, full_scale_n);
}

/// A force has enough bits, and room for sums.
static inline bool fits(float force_n, float full_scale_n)
{
    return within(force_n / full_scale_n, FIXED_Q31_SMALLEST, 0.25f);
}

#endif
