// One sample of the friction model, Eqs. (3) to (6), (8) and (9), in Q31. law_f32.h derives the equations. This file
// adds the formats.
//
// Magnitudes are unsigned: a force is at most 2^31 - 1, or 2^31 in a corrupt state, and both fit. The sign is put back
// at the end, so f(-u, -F) = -f(u, F) holds to the last bit. Constants and fractions below 1 are Q32, and
// tribo_q31_high(a, b) = a b 2^-32 multiplies by one without a change of format.

#ifndef TRIBO_FRICTION_LAW_Q31_H
#define TRIBO_FRICTION_LAW_Q31_H

#include "tribo/friction_q31.h"

#include "relay.h"

/// 1 for a negative x, otherwise 0. sign_bit(a - b) is a < b for magnitudes below 2^31.
static inline uint32_t sign_bit(int32_t x)
{
    return (uint32_t)x >> 31;
}

/// L+ and L- at load |F| in the general case: with a table, with a slope of 1 or more, or with L limited to full scale.
void tribo_friction_q31_look_up(const tribo_friction_q31_params_t *params, uint32_t load, uint32_t L[2]);

/// Breakaway at load |F| by the affine law with a slope below 1, computed as Q31 + Q32 x Q31.
static inline uint32_t friction_q31_affine(const tribo_breakaway_q31_t *law, uint32_t load)
{
    return law->offset + tribo_q31_high(law->slope, load);
}

/// Net force n = u - F + g, saturated symmetrically at full scale, far above breakaway.
static inline int32_t friction_q31_net_force(const tribo_friction_q31_params_t *params,
                                             tribo_friction_q31_state_t        *state,
                                             int32_t                            u,
                                             int32_t                            force)
{
    return tribo_q31_saturate((int64_t)u - force + params->gravity, &state->saturated);
}

/// 2^-x in Q32 for x in Q22. The shift by the whole part stops at 31, so the result is at least 1.
static inline uint32_t friction_q31_power(uint32_t x)
{
    const uint32_t whole    = x >> 22;
    const uint32_t fraction = x << 10; // Q32
    // 2^-fraction by Horner's scheme with the polynomial of law_f32.h times 8. Its signs alternate, so each
    // step subtracts and stays within 0 to 1.
    uint32_t p = 227951076u - tribo_q31_high(fraction, 29064250u);
    p          = 1027961890u - tribo_q31_high(fraction, p);
    p          = 2976542007u - tribo_q31_high(fraction, p);
    p          = 4294956156u - tribo_q31_high(fraction, p);
    return p >> (whole < 31u ? whole : 31u);
}

/// a / b in Q32 for a < 0.95 b and b from 2^22 to 2^30.7. The relative error is 2e-7 for b above 2^25. One 32-bit
/// division gives 1/b to 11 bits or more, one Newton step the rest:
///
///     a/b ~ a c (1 + e),  c = coarse 2^-42,  e = 1 - b c
///
/// The remainder e is exact: it is below 2^31 in units of 2^-42.
static inline uint32_t friction_q31_quotient(uint32_t a, uint32_t b)
{
    const uint32_t coarse    = UINT32_MAX / (b >> 10); // 2^42 / b
    const int32_t  remainder = (int32_t)(0u - b * coarse);
    const uint32_t first     = (uint32_t)(tribo_q31_product(a, coarse) >> 10);
    const int32_t  step      = (int32_t)(tribo_q31_multiply((int32_t)(first >> 1), remainder) >> 32);
    return first + (uint32_t)(step >> 9);
}

/// The argument of Eq. (3) as a fraction, x = n/(k L) = 2 N/D. Both are shifted left together until the larger is at
/// least 2^31, so small forces lose no more bits of x than large ones.
typedef struct
{
    uint32_t N, D;
} friction_q31_argument_t;

/// Eq. (5) in the form of law_f32.h: k = B/A, A = 1 + p, p = 2^-|exponent|. `n` is 0 without Q.
///
///     exponent   Q22, -289 to 32       p   Q32
///     A          Q31, 1 to 2           B   k 2^-S A, Q32, S = k_shift: the sum of k_min and k_max fits
static inline friction_q31_argument_t friction_q31_argument(const tribo_friction_q31_params_t *params,
                                                            uint32_t                           n,
                                                            uint32_t                           L,
                                                            uint32_t                           rise)
{
    // Beyond rise_max E exceeds 2^32 and k equals k_min. A falling |n| wraps to a large rise: harmless, because Q is
    // then 0.
    const uint32_t bounded  = rise < params->rise_max ? rise : params->rise_max;
    const int32_t  moved    = (int32_t)tribo_q31_high(bounded << params->rise_shift, params->exponent_rate);
    const int32_t  exponent = moved - params->exponent_at_rest; // Q22
    const uint32_t power    = friction_q31_power(tribo_q31_magnitude(exponent));

    const uint32_t A = (UINT32_C(1) << 31) + (power >> 1); // Q31
    const uint32_t B = exponent < 0 ? params->k_max + tribo_q31_high(params->k_min, power)
                                    : params->k_min + tribo_q31_high(params->k_max, power); // times 2^-k_shift, Q32

    // x = n A/(B L). A common shift first makes n and L as large as they can be, another one then N and D.
    const uint32_t zeros = tribo_q31_leading_zeros(n | L);
    const uint32_t N     = tribo_q31_high(n << zeros, A) >> params->k_shift;
    const uint32_t D     = tribo_q31_high(L << zeros, B);
    const uint32_t up    = tribo_q31_leading_zeros(N | D);
    return (friction_q31_argument_t){.N = N << up, .D = D << up};
}

/// Eq. (3) for n >= 0 before saturation: n (1 - R(x^2)), with R from law_f32.h. N = 0 (no Q) gives n.
static inline uint32_t friction_q31_curve(uint32_t n, friction_q31_argument_t x)
{
    // R = s (r1 + r2 s)/(1 + q1 s + q2 s^2) with s = x^2 = 4 N2/D2; both multiplied by D2^2/8 so that neither
    // overflows.
    const uint32_t N2          = tribo_q31_high(x.N, x.N);
    const uint32_t D2          = tribo_q31_high(x.D, x.D);
    const uint32_t numerator   = tribo_q31_high(N2, tribo_q31_high(715814512u, D2) + tribo_q31_high(119939055u, N2));
    const uint32_t denominator = (tribo_q31_high(D2, D2) >> 3) +
                                 tribo_q31_high(N2, tribo_q31_high(948854150u, D2) + tribo_q31_high(127742980u, N2));
    return n - tribo_q31_high(n, friction_q31_quotient(numerator, denominator));
}

/// f for the net force `n` and the end-point force `force`. The relays and n[k-1] advance by one sample.
static inline int32_t friction_q31_step(const tribo_friction_q31_params_t *params,
                                        tribo_friction_q31_state_t        *state,
                                        int32_t                            n,
                                        int32_t                            force,
                                        tribo_friction_q31_signals_t      *signals)
{
    const int32_t  n_before     = state->n;
    const uint32_t negative     = sign_bit(n);
    const uint32_t was_negative = sign_bit(n_before);
    const uint32_t load         = tribo_q31_magnitude(force);

    // Each comparator of the relays uses the breakaway of its own sign: L for that of n, L_before for that of n[k-1].
    uint32_t L        = friction_q31_affine(&params->law[negative], load);
    uint32_t L_before = friction_q31_affine(&params->law[was_negative], load);
    if (!params->is_shallow)
    {
        uint32_t both[2];
        tribo_friction_q31_look_up(params, load, both);
        L        = both[negative];
        L_before = both[was_negative];
    }
    const uint32_t size        = tribo_q31_magnitude(n);
    const uint32_t size_before = tribo_q31_magnitude(n_before);
    const int32_t  rise        = (int32_t)(size - size_before); // v h, Eq. (6)

    state->n      = n;
    signals->n    = n;
    signals->L    = (int32_t)L;
    signals->rise = rise;

    // Eq. (9) and the reset rule of Fig. 5: `deep` uses n[k-1], so that one large step out of the deep region still
    // counts.
    const uint32_t inside = sign_bit((int32_t)(size - tribo_q31_high(params->set_level, L)));
    const uint32_t deep   = sign_bit((int32_t)(tribo_q31_high(params->reset_level, L_before) - size_before));
    const uint32_t back   = sign_bit(rise) | (negative ^ was_negative);
    const uint32_t events = relay_events(negative, was_negative, inside, deep, back);
    const uint32_t relays = relay_step(&state->relay, params->pulse_width, events);
    const uint32_t Q      = relay_q(relays, negative, sign_bit((int32_t)(size_before - size)));
    signals->relays       = (uint8_t)(relays | Q * TRIBO_RELAY_Q);

    if (L == 0u) // in params that no init has made, which are all 0; the curve would divide by it
    {
        signals->f = 0;
        return 0;
    }
    // Eq. (3): without Q the argument is 0 and the curve is n itself. Eq. (4) then limits f to breakaway.
    const friction_q31_argument_t x      = friction_q31_argument(params, size * Q, L, (uint32_t)rise);
    const uint32_t                curved = friction_q31_curve(size, x);
    const int32_t                 held   = (int32_t)(curved < L ? curved : L);
    const int32_t                 f      = n < 0 ? -held : held;
    signals->f                           = f;
    return f;
}

#endif
