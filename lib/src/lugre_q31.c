#include "tribo/lugre_q31.h"

#include "fixed_q31.h"
#include "tribo/quantize_q31.h"

#include <stddef.h>

#define ONE_Q31 (UINT32_C(1) << 31)
#define ONE_Q20 (INT32_C(1) << 20)

/// The most bits, up to `bits_max`, with which x is below 2^31; x itself is.
static int32_t bits_for(float x, int32_t bits_max)
{
    int32_t bits = bits_max;
    while (!(scaled(x, bits) < 2147483648.0f))
    {
        bits--;
    }
    return bits;
}

static tribo_status_t quantize_side(tribo_lugre_q31_params_t    *out,
                                    uint32_t                     side,
                                    const tribo_breakaway_f32_t *law,
                                    float                        full_scale_n)
{
    const float offset = law->offset_n / full_scale_n;
    if (!(offset >= FIXED_Q31_SMALLEST && offset < 1.0f))
    {
        return TRIBO_ERR_BREAKAWAY_OFFSET;
    }
    out->offset[side] = (uint32_t)fixed(offset, 31);
    out->slope[side]  = fixed_unsigned(law->slope, 28);
    return TRIBO_OK;
}

static tribo_status_t quantize_lugre(tribo_lugre_q31_params_t       *out,
                                     const tribo_lugre_f32_params_t *f32,
                                     float                           full_scale_n)
{
    const int32_t divisor_bits = bits_for(f32->a + f32->b_and_1, 30);
    const int32_t c_bits       = bits_for(f32->c, 50);
    if (divisor_bits < 10)
    {
        return TRIBO_ERR_BRISTLE_DAMPING;
    }
    tribo_status_t status = quantize_side(out, 0, &f32->law[0], full_scale_n);
    status                = status != TRIBO_OK ? status : quantize_side(out, 1, &f32->law[1], full_scale_n);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!(magnitude(f32->gravity_n) <= full_scale_n))
    {
        return TRIBO_ERR_GRAVITY;
    }
    out->a       = fixed_unsigned(f32->a, divisor_bits);
    out->b_and_1 = fixed_unsigned(f32->b_and_1, divisor_bits);
    out->one     = UINT32_C(1) << divisor_bits;
    out->beta    = fixed(f32->beta, 20);
    out->c       = fixed_unsigned(f32->c, c_bits);
    out->c_shift = (uint8_t)c_bits;
    out->stuck   = fixed_unsigned(f32->stuck, 32);
    out->gamma_g = fixed(f32->gamma_g, 28);
    out->gravity = fixed_force(f32->gravity_n, full_scale_n);
    return TRIBO_OK;
}

tribo_status_t tribo_lugre_q31_init(tribo_lugre_q31_params_t       *params,
                                    const tribo_lugre_f32_config_t *config,
                                    const tribo_arm_f32_config_t   *arm,
                                    float                           sample_time_s,
                                    float                           full_scale_n)
{
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    if (!full_scale_ok(full_scale_n))
    {
        return TRIBO_ERR_FULL_SCALE;
    }
    tribo_lugre_f32_params_t f32;
    tribo_lugre_q31_params_t made;
    tribo_status_t           status = tribo_lugre_f32_init(&f32, config, arm, sample_time_s);
    status                          = status != TRIBO_OK ? status : quantize_lugre(&made, &f32, full_scale_n);
    if (status == TRIBO_OK)
    {
        *params = made;
    }
    return status;
}

void tribo_lugre_q31_reset(tribo_lugre_q31_state_t *state)
{
    state->bristle   = 0;
    state->drive     = 0;
    state->saturated = 0;
}

static int32_t affine(const tribo_lugre_q31_params_t *params, uint32_t side, uint32_t load)
{
    const uint64_t L = params->offset[side] + (tribo_q31_product(params->slope[side], load) >> 28);
    return L < TRIBO_Q31_MAX ? (int32_t)L : TRIBO_Q31_MAX;
}

/// With the sign of `sign`; x below 2^63.
static int64_t with_sign(uint64_t x, int64_t sign)
{
    return sign < 0 ? -(int64_t)x : (int64_t)x;
}

/// x part, `part` in Q31, towards zero; of an x that does not fit in 32 bits, the last ten are dropped.
static int64_t times(int64_t x, uint32_t part)
{
    const uint64_t size = x < 0 ? (uint64_t)-x : (uint64_t)x;
    const uint64_t y    = size >> 32 == 0u ? tribo_q31_product((uint32_t)size, part) >> 31
                                           : tribo_q31_product((uint32_t)(size >> 10), part) >> 21;
    return with_sign(y, x);
}

/// L / (L + path), Q31; 1 is 2^31. `path` is below 2^52.
static uint32_t yielding(int32_t L, uint64_t path)
{
    if (path == 0u)
    {
        return ONE_Q31;
    }
    const uint64_t whole    = (uint32_t)L + path;
    const uint32_t high     = (uint32_t)(whole >> 32);
    const uint32_t too_long = high == 0u ? 0u : 32u - tribo_q31_leading_zeros(high);
    return tribo_q31_ratio((uint32_t)L >> too_long, (uint32_t)(whole >> too_long));
}

/// P, at most 1000 FS.
static int64_t pull(const tribo_lugre_q31_params_t *params, int32_t bristle, uint32_t inverse)
{
    const uint64_t follows = tribo_q31_product((uint32_t)(ONE_Q20 + params->beta), inverse) >> 31;
    const int32_t  part    = (int32_t)follows - params->beta; // Q20
    return tribo_q31_shift_to_zero(tribo_q31_multiply(part, bristle), 20);
}

/// 1 / (1 + b + a/D*), Q31; below 1, as c from 1e-6 and L from 1e-6 FS leave bits of a/D* where b has none.
static uint32_t share(const tribo_lugre_q31_params_t *params, uint32_t inverse)
{
    const uint32_t divisor = params->b_and_1 + (uint32_t)(tribo_q31_product(params->a, inverse) >> 31);
    return tribo_q31_ratio(params->one, divisor);
}

/// Z after the motion that the drive `r` makes; L is that of its direction.
static int32_t moved(const tribo_lugre_q31_params_t *params, int32_t bristle, int32_t r, int32_t L)
{
    const uint64_t path    = tribo_q31_product(params->c, tribo_q31_magnitude(r)) >> params->c_shift; // below 2^51
    const uint32_t inverse = yielding(L, path);
    // (Z + c r)/D, which is Z/D + L (1 - 1/D); the latter where c r does not fit.
    const int64_t Z = path < ONE_Q31 ? times(bristle + with_sign(path, r), inverse)
                                     : times(bristle, inverse) + times(with_sign((uint32_t)L, r), ONE_Q31 - inverse);
    return (int32_t)Z;
}

int32_t tribo_lugre_q31_step(const tribo_lugre_q31_params_t *params,
                             tribo_lugre_q31_state_t        *state,
                             int32_t                         u,
                             int32_t                         force,
                             tribo_lugre_q31_signals_t      *signals)
{
    const int32_t  n        = tribo_q31_saturate((int64_t)u - force + params->gravity, &state->saturated);
    const uint32_t load     = tribo_q31_magnitude(force);
    const int32_t  positive = affine(params, 0, load);
    const int32_t  negative = affine(params, 1, load);

    // The linear equation for f, with the D of an arm that sticks.
    const int64_t  carried = n + tribo_q31_shift_to_zero(tribo_q31_multiply(params->gamma_g, state->drive), 28); // n'
    const int64_t  stretch = carried - state->bristle;
    const uint64_t size    = stretch < 0 ? (uint64_t)-stretch : (uint64_t)stretch; // below 2^36
    const uint64_t path    = tribo_q31_product((uint32_t)(size >> 4), params->stuck) >> 28;
    const uint32_t inverse = yielding(stretch >= 0 ? positive : negative, path); // 1/D*
    int64_t        r       = times(carried - pull(params, state->bristle, inverse), share(params, inverse));
    int64_t        f       = carried - r;
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
    state->bristle = moved(params, state->bristle, state->drive, r >= 0 ? positive : negative);

    signals->n       = n;
    signals->L       = f >= 0 ? positive : negative;
    signals->bristle = state->bristle;
    signals->f       = (int32_t)f;
    return (int32_t)f;
}
