// From physical parameters in float to fixed point: the set-up of the _q31 modules. Nothing here is called in a tick.
//
// Every parameter is first accepted by its f32 module, so the values here are finite and in range. All scaling is by powers of
// two, which is exact in float; each number is then rounded once, to nearest. What runs in fixed point is therefore within
// half a unit in the last place of the design, and the checks (stability, headroom) are made on the rounded numbers.

#ifndef TRIBO_FIXED_Q31_H
#define TRIBO_FIXED_Q31_H

#include "tribo/force_f32.h"
#include "tribo/q31.h"
#include "tribo/quantize_q31.h"

#include "ieee_f32.h"

#define FIXED_Q31_SMALLEST 1.0e-6f     // as a fraction of full scale or of 1: below it less than 11 bits are left
#define FIXED_Q31_FULL     0.99999994f // the largest float below full scale, which itself does not fit

static inline float larger(float a, float b)
{
    return a > b ? a : b;
}

/// x 2^bits for `bits` of either sign; exact but for overflow and underflow.
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
        return (int32_t)y; // from 2^23 on a float is an integer, and adding 0.5 could change it
    }
    return (int32_t)(y < 0.0f ? y - 0.5f : y + 0.5f);
}

/// x 2^bits rounded to nearest, for x >= 0; 2^32 or more becomes UINT32_MAX.
static inline uint32_t fixed_unsigned(float x, int32_t bits)
{
    const float y = scaled(x, bits);
    if (y >= 8388608.0f)
    {
        return y < 4294967296.0f ? (uint32_t)y : UINT32_MAX;
    }
    return (uint32_t)(y + 0.5f);
}

/// A force of at most full scale in Q31. Full scale itself, 2^31, does not fit and becomes +-(2^31 - 1), symmetrically.
static inline int32_t fixed_force(float force_n, float full_scale_n)
{
    const float part = force_n / full_scale_n;
    return magnitude(part) < 1.0f ? fixed(part, 31) : (part < 0.0f ? -TRIBO_Q31_MAX : TRIBO_Q31_MAX);
}

/// The accepted full scales: 1 mN to the largest force of the f32 modules.
static inline bool full_scale_ok(float full_scale_n)
{
    return within(full_scale_n, 1.0e-3f, TRIBO_F32_FORCE_MAX_N);
}

/// Quantises the cascade in `f32` (headroom_q31.c) for |e| <= `e_peak` and |u - feedforward| <= `s_peak`, both as a fraction of
/// full scale. The scale of each node comes from its worst-case peak, so that none can overflow. `f32` is then made again
/// from the quantised numbers (by `config`, or as a cascade alone if it is null), which checks that they are stable. This runs
/// twice, so that scales and report belong to the numbers that run. `headroom` may be null.
tribo_status_t headroom_q31_quantize(tribo_biquad_q31_params_t           *out,
                                     tribo_controller_f32_params_t       *f32,
                                     const tribo_controller_f32_config_t *config,
                                     float                                e_peak,
                                     float                                s_peak,
                                     tribo_headroom_q31_t                *headroom);

#endif
