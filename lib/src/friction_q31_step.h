// One sample of the friction model, Eqs. (3) to (6), (8), (9), in magnitudes, so that signs cannot matter.

#ifndef TRIBO_FRICTION_Q31_STEP_H
#define TRIBO_FRICTION_Q31_STEP_H

#include "tribo/friction_q31.h"

#include "relay_step.h"

/// 1 for a negative x, else 0: of a difference of magnitudes, a comparison without a branch.
static inline uint32_t sign_bit(int32_t x)
{
    return (uint32_t)x >> 31;
}

/// L+ and L- at load |F| of any params: from a table, or where a slope is 1 or more or L ends at full scale.
void tribo_friction_q31_look_up(const tribo_friction_q31_params_t *params, uint32_t load, uint32_t L[2]);

/// L at load |F| of an affine law with a slope below 1.
static inline uint32_t friction_q31_affine(const tribo_breakaway_q31_t *law, uint32_t load)
{
    return law->offset + tribo_q31_high(law->slope, load);
}

/// n = u - F + g.
static inline int32_t friction_q31_net_force(const tribo_friction_q31_params_t *params,
                                             tribo_friction_q31_state_t        *state,
                                             int32_t                            u,
                                             int32_t                            force)
{
    return tribo_q31_saturate((int64_t)u - force + params->gravity, &state->saturated);
}

/// 2^-x in Q32, x in Q22; 2^-31 stands for what is smaller.
static inline uint32_t friction_q31_power(uint32_t x)
{
    const uint32_t whole    = x >> 22;
    const uint32_t fraction = x << 10; // Q32
    // The polynomial of friction_f32_step.h, times 8.
    uint32_t p = 227951076u - tribo_q31_high(fraction, 29064250u);
    p          = 1027961890u - tribo_q31_high(fraction, p);
    p          = 2976542007u - tribo_q31_high(fraction, p);
    p          = 4294956156u - tribo_q31_high(fraction, p);
    return p >> (whole < 31u ? whole : 31u);
}

/// a / b in Q32 for a below 0.95 b, b from 2^22 to 2^30.7, within 2e-7 of itself where b is over 2^25: a division for 11
/// bits of 1/b or more, and one of Newton's steps with the remainder, which fits 32 bits.
static inline uint32_t friction_q31_quotient(uint32_t a, uint32_t b)
{
    const uint32_t coarse    = UINT32_MAX / (b >> 10); // 2^42 / b
    const int32_t  remainder = (int32_t)(0u - b * coarse);
    const uint32_t first     = (uint32_t)(tribo_q31_product(a, coarse) >> 10);
    const int32_t  step      = (int32_t)(tribo_q31_multiply((int32_t)(first >> 1), remainder) >> 32);
    return first + (uint32_t)(step >> 9);
}

/// The argument of Eq. (3), x = n/(k L) = 2 N/D, as two numbers of which the larger is over 2^31: one division serves
/// k and x.
typedef struct
{
    uint32_t N, D;
} friction_q31_argument_t;

/// Eq. (5) as in friction_f32_step.h: k = B/A with A = 1 + 2^-|exponent|. `n` is 0 without Q.
static inline friction_q31_argument_t friction_q31_argument(const tribo_friction_q31_params_t *params,
                                                            uint32_t                           n,
                                                            uint32_t                           L,
                                                            uint32_t                           rise)
{
    // A fall, for which there is no Q, wraps to a large rise.
    const uint32_t bounded  = rise < params->rise_max ? rise : params->rise_max;
    const int32_t  moved    = (int32_t)tribo_q31_high(bounded << params->rise_shift, params->exponent_rate);
    const int32_t  exponent = moved - params->exponent_at_rest; // Q22
    const uint32_t power    = friction_q31_power(tribo_q31_magnitude(exponent));

    const uint32_t A = (UINT32_C(1) << 31) + (power >> 1); // Q31
    const uint32_t B = exponent < 0 ? params->k_max + tribo_q31_high(params->k_min, power)
                                    : params->k_min + tribo_q31_high(params->k_max, power); // times 2^-k_shift, Q32

    const uint32_t zeros = tribo_q31_leading_zeros(n | L);
    const uint32_t N     = tribo_q31_high(n << zeros, A) >> params->k_shift;
    const uint32_t D     = tribo_q31_high(L << zeros, B);
    const uint32_t up    = tribo_q31_leading_zeros(N | D);
    return (friction_q31_argument_t){.N = N << up, .D = D << up};
}

/// Eq. (3) for n from 0 with Q, before the saturation: n (1 - R(x^2)), and R is 0 for N = 0.
static inline uint32_t friction_q31_curve(uint32_t n, friction_q31_argument_t x)
{
    // R = s (r1 + r2 s)/(1 + q1 s + q2 s^2), s = 4 N2/D2; numerator and denominator over 8 D2^2.
    const uint32_t N2          = tribo_q31_high(x.N, x.N);
    const uint32_t D2          = tribo_q31_high(x.D, x.D);
    const uint32_t numerator   = tribo_q31_high(N2, tribo_q31_high(715814512u, D2) + tribo_q31_high(119939055u, N2));
    const uint32_t denominator = (tribo_q31_high(D2, D2) >> 3) +
                                 tribo_q31_high(N2, tribo_q31_high(948854150u, D2) + tribo_q31_high(127742980u, N2));
    return n - tribo_q31_high(n, friction_q31_quotient(numerator, denominator));
}

static inline int32_t friction_q31_step(const tribo_friction_q31_params_t *params,
                                        tribo_friction_q31_state_t        *state,
                                        int32_t                            n,
                                        int32_t                            force,
                                        tribo_friction_q31_signals_t      *signals)
{
    const int32_t  n_before     = state->n;
    const uint32_t size         = tribo_q31_magnitude(n);
    const uint32_t size_before  = tribo_q31_magnitude(n_before);
    const int32_t  rise         = (int32_t)(size - size_before); // v h, Eq. (6)
    const uint32_t negative     = sign_bit(n);
    const uint32_t was_negative = sign_bit(n_before);
    const uint32_t load         = tribo_q31_magnitude(force);

    uint32_t L        = friction_q31_affine(&params->law[negative], load); // breakaway on the side of n
    uint32_t L_before = friction_q31_affine(&params->law[was_negative], load);
    if (!params->is_shallow)
    {
        uint32_t both[2];
        tribo_friction_q31_look_up(params, load, both);
        L        = both[negative];
        L_before = both[was_negative];
    }

    // Stored early, to shorten their lives.
    state->n      = n;
    signals->n    = n;
    signals->L    = (int32_t)L;
    signals->rise = rise;

    const uint32_t inside = sign_bit((int32_t)(size - tribo_q31_high(params->set_level, L)));
    const uint32_t deep   = sign_bit((int32_t)(tribo_q31_high(params->reset_level, L_before) - size_before));
    const uint32_t back   = sign_bit(rise) | (negative ^ was_negative);
    const uint32_t events = relay_events(negative, was_negative, inside, deep, back);
    const uint32_t relays = relay_step(&state->relay, params->pulse_width, events);
    const uint32_t Q      = relay_q(relays, negative, sign_bit(-rise));
    signals->relays       = (uint8_t)(relays | Q * TRIBO_RELAY_Q);

    const friction_q31_argument_t x      = friction_q31_argument(params, size * Q, L, (uint32_t)rise);
    const uint32_t                curved = friction_q31_curve(size, x);
    const int32_t                 held   = (int32_t)(curved < L ? curved : L); // Eq. (4)
    const int32_t                 f      = n < 0 ? -held : held;
    signals->f                           = f;
    return f;
}

#endif
