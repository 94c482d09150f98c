// LuGre friction of a constrained arm in Q31: the twin of lugre_f32.h, equation for equation.
//
// Forces are Q31 of one full scale FS. The net force saturates at FS (counted). Where L(F) is beyond FS, it is FS. Symmetric
// parameters give f(-u, -F) = -f(u, F) exactly, and |f| <= L, |Z| <= the largest L seen, always.
// f is within 1e-7 N of the f32 module's at a full scale of 2 N, for the paper's parameters at 1 kHz
// (tests/unit/test_lugre_q31.c holds 2e-7).
// Three 32-bit divisions; a breakaway table adds one and the only loop, over its points. Nothing overflows for any Z and r.
// Not synchronized: one state, one tick.

#ifndef TRIBO_FRICTION_LUGRE_Q31_H
#define TRIBO_FRICTION_LUGRE_Q31_H

#include "tribo/friction_q31.h"

#include "law_q31.h"

#define LUGRE_ONE_Q31 (UINT32_C(1) << 31)
#define LUGRE_ONE_Q20 (INT32_C(1) << 20)

/// x with the sign of `sign`; x below 2^63.
static inline int64_t lugre_q31_with_sign(uint64_t x, int64_t sign)
{
    return sign < 0 ? -(int64_t)x : (int64_t)x;
}

/// x times `part`, Q31, towards zero; drops the last ten bits of an x that does not fit 32 bits.
static inline int64_t lugre_q31_times(int64_t x, uint32_t part)
{
    const uint64_t size = x < 0 ? (uint64_t)-x : (uint64_t)x;
    const uint64_t y    = size >> 32 == 0u ? tribo_q31_product((uint32_t)size, part) >> 31
                                           : tribo_q31_product((uint32_t)(size >> 10), part) >> 21;
    return lugre_q31_with_sign(y, x);
}

/// L / (L + path), Q31; 1 is 2^31. `path` is below 2^52.
static inline uint32_t lugre_q31_yielding(int32_t L, uint64_t path)
{
    if (path == 0u)
    {
        return LUGRE_ONE_Q31;
    }
    const uint64_t whole    = (uint32_t)L + path;
    const uint32_t high     = (uint32_t)(whole >> 32);
    const uint32_t too_long = high == 0u ? 0u : 32u - tribo_q31_leading_zeros(high);
    return tribo_q31_ratio((uint32_t)L >> too_long, (uint32_t)(whole >> too_long));
}

/// P, at most 1000 FS.
static inline int64_t lugre_q31_pull(const tribo_lugre_q31_params_t *params, int32_t bristle, uint32_t inverse)
{
    const uint64_t follows = tribo_q31_product((uint32_t)(LUGRE_ONE_Q20 + params->beta), inverse) >> 31;
    const int32_t  part    = (int32_t)follows - params->beta; // Q20
    return tribo_q31_shift_to_zero(tribo_q31_multiply(part, bristle), 20);
}

/// 1 / (1 + b + a/D*), Q31; below 1: c from 1e-6 and L from 1e-6 FS keep bits of a/D* where b has none.
static inline uint32_t lugre_q31_share(const tribo_lugre_q31_params_t *params, uint32_t inverse)
{
    const uint32_t divisor = params->b_and_1 + (uint32_t)(tribo_q31_product(params->a, inverse) >> 31);
    return tribo_q31_ratio(params->one, divisor);
}

/// Z after the motion by the drive `r`; L is for its direction.
static inline int32_t lugre_q31_moved(const tribo_lugre_q31_params_t *params, int32_t bristle, int32_t r, int32_t L)
{
    const uint64_t path    = tribo_q31_product(params->c, tribo_q31_magnitude(r)) >> params->c_shift; // below 2^51
    const uint32_t inverse = lugre_q31_yielding(L, path);
    // (Z + c r)/D, which is Z/D + L (1 - 1/D); the latter where c r does not fit.
    const int64_t Z = path < LUGRE_ONE_Q31
                          ? lugre_q31_times(bristle + lugre_q31_with_sign(path, r), inverse)
                          : lugre_q31_times(bristle, inverse) +
                                lugre_q31_times(lugre_q31_with_sign((uint32_t)L, r), LUGRE_ONE_Q31 - inverse);
    return (int32_t)Z;
}

/// L+ and L- at the end-point force.
static inline void lugre_q31_breakaway(const tribo_friction_q31_params_t *friction, int32_t force, int32_t L[2])
{
    const uint32_t load = tribo_q31_magnitude(force);
    uint32_t       both[2];
    if (friction->is_shallow)
    {
        both[0] = friction_q31_affine(&friction->law[0], load);
        both[1] = friction_q31_affine(&friction->law[1], load);
    }
    else
    {
        tribo_friction_q31_look_up(friction, load, both);
    }
    L[0] = (int32_t)both[0];
    L[1] = (int32_t)both[1];
}

/// f for the net force `n` and the end-point force `force`; Z and r advance by one sample.
static inline int32_t lugre_q31_step(const tribo_lugre_q31_params_t    *params,
                                     const tribo_friction_q31_params_t *friction,
                                     tribo_lugre_q31_state_t           *state,
                                     int32_t                            n,
                                     int32_t                            force,
                                     tribo_friction_q31_signals_t      *signals)
{
    int32_t both[2];
    lugre_q31_breakaway(friction, force, both);
    const int32_t positive = both[0];
    const int32_t negative = both[1];

    // The linear equation for f, with the D of a sticking arm.
    const int64_t  carried = n + tribo_q31_shift_to_zero(tribo_q31_multiply(params->gamma_g, state->drive), 28); // n'
    const int64_t  stretch = carried - state->bristle;
    const uint64_t size    = stretch < 0 ? (uint64_t)-stretch : (uint64_t)stretch; // below 2^36
    const uint64_t path    = tribo_q31_product((uint32_t)(size >> 4), params->stuck) >> 28;
    const uint32_t inverse = lugre_q31_yielding(stretch >= 0 ? positive : negative, path); // 1/D*
    int64_t        r =
        lugre_q31_times(carried - lugre_q31_pull(params, state->bristle, inverse), lugre_q31_share(params, inverse));
    int64_t f = carried - r;
    if (f > positive)
    {
        f = positive;
        r = carried - f;
    }
    else if (f < -negative)
    {
        f = -negative;
        r = carried - f;
    }
    state->drive   = tribo_q31_saturate(r, &state->saturated);
    state->bristle = lugre_q31_moved(params, state->bristle, state->drive, r >= 0 ? positive : negative);

    *signals = (tribo_friction_q31_signals_t){.n = n, .L = f >= 0 ? positive : negative, .f = (int32_t)f};
    return (int32_t)f;
}

#endif
