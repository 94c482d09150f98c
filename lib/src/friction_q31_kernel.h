// One sample of the friction model, inline, for a net force within the symmetric range.

#ifndef TRIBO_FRICTION_Q31_KERNEL_H
#define TRIBO_FRICTION_Q31_KERNEL_H

#include "tribo/friction_q31.h"

#include "relay_kernel.h"
#include "usual.h"

#include <stddef.h>

typedef struct
{
    uint32_t L;     ///< breakaway on the side of n
    uint32_t reset; ///< c2 times the one on the side of n[k-1]
} friction_q31_levels_t;

/// Those of any params at load |F|: from a table, or where a slope is 1 or more or L ends at full scale.
friction_q31_levels_t tribo_friction_q31_levels(const tribo_friction_q31_params_t *params,
                                                uint32_t                           load,
                                                uint32_t                           side,
                                                uint32_t                           side_before);

/// L at load |F| by a plain law.
static inline uint32_t friction_q31_affine(const tribo_breakaway_q31_t *law, uint32_t load)
{
    return law->offset + tribo_q31_high(law->slope, load);
}

/// 2^-y in Q32, of y in Q22; 2^-31 stands for what is below it.
static inline uint32_t friction_q31_power(uint32_t y)
{
    const uint32_t whole = y >> 22;
    const uint32_t f     = y << 10;
    // The polynomial of friction_f32_kernel.h times 8.
    uint32_t p = 227951076u - tribo_q31_high(f, 29064250u);
    p          = 1027961890u - tribo_q31_high(f, p);
    p          = 2976542007u - tribo_q31_high(f, p);
    p          = 4294956156u - tribo_q31_high(f, p);
    return p >> (whole < 31u ? whole : 31u);
}

/// a / b in Q32 for a below 0.95 b, b from 2^22 to 2^30.7, within 2e-7 of itself where b is over 2^25: a division for 11
/// bits of 1/b or more, and one of Newton's steps with what they leave over, which fits 32 bits.
static inline uint32_t friction_q31_quotient(uint32_t a, uint32_t b)
{
    const uint32_t coarse = UINT32_MAX / (b >> 10);               // 2^42 / b
    const int32_t  left   = (int32_t)(uint32_t)(0u - b * coarse); // of 2^42
    const uint32_t first  = (uint32_t)(tribo_q31_product(a, coarse) >> 10);
    const int32_t  step   = (int32_t)(tribo_q31_multiply(tribo_q31_opaque((int32_t)(first >> 1)), left) >> 32);
    return first + (uint32_t)(step >> 9);
}

/// Magnitude of Eq. (3) before the saturation, as in friction_f32_kernel.h: n (1 - R), k = B/A. Without q, R is 0.
static inline uint32_t friction_q31_curve(const tribo_friction_q31_params_t *params,
                                          uint32_t                           n,
                                          uint32_t                           L,
                                          uint32_t                           rise,
                                          uint32_t                           q)
{
    // A rise below 0, for which there is no q, is taken for a large one.
    const uint32_t bounded  = rise < params->rise_max ? rise : params->rise_max;
    const int32_t  y        = (int32_t)tribo_q31_high(bounded << params->rise_shift, params->rate) - params->y_at_0;
    const uint32_t negative = (uint32_t)y >> 31;
    const uint32_t w        = friction_q31_power(((uint32_t)y ^ (0u - negative)) + negative);
    const uint32_t A        = (UINT32_C(1) << 31) + (w >> 1); // Q31
    const uint32_t B        = params->k[negative] + tribo_q31_high(params->k[negative + 1u], w);

    // x = n/(k L) = 2 N/D, the larger of N and D from 2^31.
    const uint32_t zeros = tribo_q31_leading_zeros(n | L);
    const uint32_t above = (tribo_q31_high(n << zeros, A) >> params->k_shift) & q;
    const uint32_t below = tribo_q31_high(L << zeros, B);
    const uint32_t up    = tribo_q31_leading_zeros(above | below);
    const uint32_t N     = above << up;
    const uint32_t D     = below << up;

    // R = s (r1 + r2 s)/(1 + q1 s + q2 s^2), s = 4 N2/D2; above and below the line over 8 D2^2.
    const uint32_t N2      = tribo_q31_high(N, N);
    const uint32_t D2      = tribo_q31_high(D, D);
    const uint32_t R_above = tribo_q31_high(N2, tribo_q31_high(715814512u, D2) + tribo_q31_high(119939055u, N2));
    const uint32_t R_below = (tribo_q31_high(D2, D2) >> 3) +
                             tribo_q31_high(N2, tribo_q31_high(948854150u, D2) + tribo_q31_high(127742980u, N2));
    return n - tribo_q31_high(n, friction_q31_quotient(R_above, R_below));
}

/// `any` is false, a constant, where the params are plain.
static inline int32_t friction_q31_kernel(const tribo_friction_q31_params_t *params,
                                          tribo_friction_q31_state_t        *state,
                                          int32_t                            n,
                                          int32_t                            force,
                                          tribo_friction_q31_signals_t      *signals,
                                          bool                               any)
{
    const int32_t  n_before    = state->n;
    const uint32_t side        = (uint32_t)n >> 31;
    const uint32_t side_before = (uint32_t)n_before >> 31;
    const uint32_t load        = tribo_q31_magnitude(force);
    const uint32_t size        = tribo_q31_magnitude(n);
    const uint32_t size_before = tribo_q31_magnitude(n_before);

    friction_q31_levels_t level;
    if (any && !params->plain)
    {
        level = tribo_friction_q31_levels(params, load, side, side_before);
    }
    else
    {
        level.L     = friction_q31_affine(&params->law[side], load);
        level.reset = friction_q31_affine(&params->reset[side_before], load);
    }
    const uint32_t L    = level.L;
    const uint32_t rise = size - size_before;

    // As early as can be, so that what comes does not have to keep it.
    state->n      = n;
    signals->n    = n;
    signals->L    = (int32_t)L;
    signals->rise = (int32_t)rise;

    const uint32_t inside = size - tribo_q31_high(params->set_level, L);
    const uint32_t deep   = level.reset - size_before;
    const uint32_t back   = rise | (uint32_t)(n ^ n_before);
    const uint32_t relays =
        relay_kernel(&state->relay, params->pulse_width, friction_relay_events(side, side_before, inside, deep, back));
    const uint32_t q = relay_armed_rise(relays, side, rise); // Q of the side of n, where |n| rises

    signals->relays = (uint8_t)(relays | (q & TRIBO_RELAY_Q));

    const uint32_t curved = friction_q31_curve(params, size, L, rise, q);
    const int32_t  held   = (int32_t)(curved < L ? curved : L);
    const int32_t  f      = side != 0u ? -held : held;

    signals->f = f;
    return f;
}

#endif
