// One sample of the friction model, inline, for a net force within the symmetric range.

#ifndef TRIBO_FRICTION_Q31_KERNEL_H
#define TRIBO_FRICTION_Q31_KERNEL_H

#include "tribo/friction_q31.h"

#include "relay_kernel.h"
#include "usual.h"

#include <stddef.h>

/// L+ and L- at load |F| from the table.
void tribo_friction_q31_look_up(const tribo_friction_q31_params_t *params, uint32_t load, uint32_t L[2]);

/// L at load |F| by an affine law, at most full scale.
static inline uint32_t friction_q31_affine(const tribo_breakaway_q31_t *law, uint32_t load)
{
    const uint64_t L = law->offset + tribo_q31_product(law->slope, load);
    return (uint32_t)tribo_q31_opaque(TRIBO_USUAL(L >> 59 == 0u) ? (int32_t)(L >> 28) : TRIBO_Q31_MAX);
}

/// 2^-y in Q32, of y in Q22; 2^-31 stands for what is below it.
static inline uint32_t friction_q31_power(uint32_t y)
{
    const uint32_t whole = y >> 22;
    const uint32_t f     = y << 10;
    // The polynomial of friction_f32_kernel.h.
    uint32_t p = 227951076u - tribo_q31_high(f, 29064250u);
    p          = 1027961890u - tribo_q31_high(f, p);
    p          = 2976542007u - tribo_q31_high(f, p);
    p          = 4294956156u - tribo_q31_high(f, p);
    return p >> (whole < 31u ? whole : 31u);
}

/// a / b in Q32 for a below 0.95 b, b from 2^24 to 2^31, within 2e-7 of itself: a division for 12 bits of 1/b or more,
/// and one of Newton's steps with what they leave over, which fits 32 bits.
static inline uint32_t friction_q31_quotient(uint32_t a, uint32_t b)
{
    const uint32_t coarse = UINT32_MAX / (b >> 11);               // 2^43 / b
    const int32_t  left   = (int32_t)(uint32_t)(0u - b * coarse); // of 2^43
    const uint32_t first  = (uint32_t)(tribo_q31_product(a, coarse) >> 11);
    const int32_t  step   = (int32_t)(tribo_q31_multiply((int32_t)(first >> 1), left) >> 32);
    return first + (uint32_t)(step >> 10);
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

    // x = n/(k L) = 4 N/D, D from 2^31.
    const uint32_t most  = L + (L >> 2) + (L >> 3);
    const uint32_t half  = n >> 1 < most ? n >> 1 : most;
    const uint32_t above = tribo_q31_high(half << (params->L_shift - 1u), A);
    const uint32_t below = tribo_q31_high(L << params->L_shift, B);
    const uint32_t up    = tribo_q31_leading_zeros(below);
    const int32_t  left  = (int32_t)up + 1 - params->k_shift;
    const uint32_t D     = below << up;
    const uint32_t N     = (left >= 0 ? above << left : above >> -left) & (0u - q);

    // R = s (r1 + r2 s)/(1 + q1 s + q2 s^2), s = 16 N2/D2; above and below the line over 16 D2^2.
    const uint32_t N2      = tribo_q31_high(N, N);
    const uint32_t D2      = tribo_q31_high(D, D);
    const uint32_t R_above = tribo_q31_high(N2, tribo_q31_high(1431629024u, D2) + tribo_q31_high(959512440u, N2));
    const uint32_t R_below = (tribo_q31_high(D2, D2) >> 4) +
                             tribo_q31_high(N2, tribo_q31_high(1897708300u, D2) + tribo_q31_high(1021943842u, N2));
    return n - tribo_q31_high(n, friction_q31_quotient(R_above, R_below));
}

/// `any` is false, a constant, where there is no table.
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

    uint32_t L;
    uint32_t reset;
    if (any && params->table != NULL)
    {
        uint32_t both[2];
        tribo_friction_q31_look_up(params, load, both);
        L     = both[side];
        reset = tribo_q31_high(params->reset_level, both[side_before]);
    }
    else
    {
        L     = friction_q31_affine(&params->law[side], load);
        reset = friction_q31_affine(&params->reset[side_before], load);
    }
    const uint32_t rise   = size - size_before;
    const uint32_t inside = size - tribo_q31_high(params->set_level, L);
    const uint32_t deep   = reset - size_before;
    const uint32_t back   = rise | (uint32_t)(n ^ n_before);
    const uint32_t relays =
        relay_kernel(&state->relay, params->pulse_width, friction_relay_events(side, side_before, inside, deep, back));
    const uint32_t rising = (0u - rise) >> 31;
    const uint32_t q      = (relays >> (side ^ 1u)) & rising;

    const uint32_t curved = friction_q31_curve(params, size, L, rise, q);
    const int32_t  held   = (int32_t)(curved < L ? curved : L);
    const int32_t  f      = side != 0u ? -held : held;

    state->n      = n;
    signals->n    = n;
    signals->L    = (int32_t)L;
    signals->rise = (int32_t)rise;
    signals->f    = f;
    signals->q1   = (relays & TRIBO_RELAY_Q1) != 0u;
    signals->q2   = (relays & TRIBO_RELAY_Q2) != 0u;
    signals->q    = q != 0u;
    return f;
}

#endif
