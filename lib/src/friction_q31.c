#include "tribo/friction_q31.h"

#include <stddef.h>

void tribo_friction_q31_reset(tribo_friction_q31_state_t *state)
{
    state->n         = 0;
    state->saturated = 0;
    tribo_relay_reset(&state->relay);
}

/// tanh(x)/x in Q31 for s = (x/6)^2 in Q31: the rational of friction_f32.c with 6^2i folded into its coefficients, Q26.
static inline uint32_t tanh_over_x(uint32_t s)
{
    const uint32_t t = 2u * s; // so that a product's upper word is a part
    const uint32_t p =
        tribo_q31_high(tribo_q31_high(tribo_q31_high(14305276u, t) + 209100061u, t) + 300569564u, t) + 67108844u;
    const uint32_t q =
        tribo_q31_high(tribo_q31_high(tribo_q31_high(490126771u, t) + 1883439570u, t) + 1105869764u, t) + 67108864u;
    return tribo_q31_ratio(p, q, 0);
}

/// tanh(6 x) in Q31. Six times the largest sixth is below 1, see the header.
static inline int32_t tanh_of_6(int32_t x)
{
    const uint32_t size  = tribo_q31_magnitude(x);
    const uint32_t sixth = tribo_q31_part(size, tanh_over_x(tribo_q31_part(size, size)));
    return x < 0 ? -(int32_t)(6u * sixth) : (int32_t)(6u * sixth);
}

typedef struct
{
    int32_t positive;
    int32_t negative;
} breakaway_t;

static inline int32_t at_part(int32_t lower, int32_t upper, uint32_t part)
{
    return (int32_t)(lower + (((int64_t)upper - lower) * part >> 31));
}

/// Linear between the points, clamped at both ends. Visits every point, whatever the force.
static breakaway_t look_up(const tribo_breakaway_point_q31_t *table, uint32_t length, uint32_t load)
{
    uint32_t below = 0; // points at or below the force
    for (uint32_t i = 0; i < length; i++)
    {
        below += load >= (uint32_t)table[i].force;
    }
    const tribo_breakaway_point_q31_t *lower = &table[below > 0u ? below - 1u : 0u];
    const tribo_breakaway_point_q31_t *upper = &table[below < length ? below : length - 1u];

    // At the ends lower and upper are the same point, and any part of their distance is none.
    const uint32_t part = tribo_q31_ratio(load - (uint32_t)lower->force, (uint32_t)(upper->force - lower->force), 0);
    return (breakaway_t){.positive = at_part(lower->positive, upper->positive, part),
                         .negative = at_part(lower->negative, upper->negative, part)};
}

static inline int32_t affine(const tribo_breakaway_q31_t *law, uint32_t load)
{
    const uint64_t L = (uint32_t)law->offset + (tribo_q31_product((uint32_t)law->slope, load) >> 27);
    return (L >> 31) == 0u ? (int32_t)L : TRIBO_Q31_MAX;
}

static inline breakaway_t breakaway(const tribo_friction_q31_params_t *params, int32_t force)
{
    const uint32_t load = tribo_q31_magnitude(force);
    if (params->table != NULL)
    {
        return look_up(params->table, params->table_length, load);
    }
    return (breakaway_t){.positive = affine(&params->positive, load), .negative = affine(&params->negative, load)};
}

static inline int32_t level(int32_t level_q30, int32_t L)
{
    return (int32_t)(tribo_q31_product((uint32_t)level_q30, (uint32_t)L) >> 30);
}

/// Comparators in front of the relays, Fig. 12. Reset looks at n[k-1], so that one large step from above L2 to
/// below it still counts as a crossing while decreasing (Fig. 5).
static inline uint8_t relay_events(const tribo_friction_q31_params_t *params,
                                   breakaway_t                        L,
                                   int32_t                            n,
                                   int32_t                            n_before)
{
    const uint32_t set1   = n < level(params->set_level, L.positive);
    const uint32_t set2   = n > -level(params->set_level, L.negative);
    const uint32_t reset1 = (uint32_t)(n > n_before) & (uint32_t)(n_before < -level(params->reset_level, L.negative));
    const uint32_t reset2 = (uint32_t)(n < n_before) & (uint32_t)(n_before > level(params->reset_level, L.positive));
    return (uint8_t)(set1 * TRIBO_RELAY_SET1 | set2 * TRIBO_RELAY_SET2 | reset1 * TRIBO_RELAY_RESET1 |
                     reset2 * TRIBO_RELAY_RESET2);
}

/// Eq. (5): 6 k 2^-S in Q31.
static inline uint32_t k_of_rise(const tribo_friction_q31_params_t *params, int32_t rise)
{
    const int64_t x = (tribo_q31_multiply(rise, params->rate) >> params->rate_shift) - ((int64_t)params->m * 32);
    uint32_t      not_counted      = 0;
    const volatile int32_t bounded = tribo_q31_saturate(x, &not_counted); // volatile: no shortcut for the bounds
    return (uint32_t)(params->k_mean - (int32_t)(tribo_q31_multiply(params->k_half, tanh_of_6(bounded)) >> 31));
}

/// Magnitude of Eq. (3) before the saturation, on the branch of Q = 1.
static inline uint32_t hysteresis(const tribo_friction_q31_params_t *params, uint32_t n, int32_t L, int32_t rise)
{
    const uint32_t k_L = tribo_q31_part(k_of_rise(params, rise), (uint32_t)L);

    const volatile uint32_t bounded = tribo_q31_ratio(n, k_L, params->k_shift); // volatile: no shortcut for the bound
    const uint32_t          x       = bounded;
    return tribo_q31_part(n, tanh_over_x(tribo_q31_part(x, x)));
}

int32_t tribo_friction_q31_step(const tribo_friction_q31_params_t *params,
                                tribo_friction_q31_state_t        *state,
                                int32_t                            u,
                                int32_t                            force,
                                tribo_friction_q31_signals_t      *signals)
{
    const int32_t n_before = state->n;

    const int32_t     n    = tribo_q31_saturate((int64_t)u - force + params->gravity, &state->saturated);
    const uint32_t    size = tribo_q31_magnitude(n);
    const breakaway_t both = breakaway(params, force);
    const int32_t     L    = n >= 0 ? both.positive : both.negative;
    const int32_t     rise = (int32_t)size - (int32_t)tribo_q31_magnitude(n_before);
    const uint8_t     relays =
        tribo_relay_step(&state->relay, params->pulse_width, relay_events(params, both, n, n_before));
    const bool q1 = (relays & TRIBO_RELAY_Q1) != 0u;
    const bool q2 = (relays & TRIBO_RELAY_Q2) != 0u;
    const bool q  = rise > 0 && (n > 0 ? q2 : q1); // |n| has risen, so n is not 0

    // Both branches are computed, always: volatile, so that a tick costs the same on either.
    const volatile uint32_t curved = hysteresis(params, size, L, rise);
    const uint32_t          wanted = q ? curved : size;
    const int32_t           held   = wanted < (uint32_t)L ? (int32_t)wanted : L;
    const int32_t           f      = n < 0 ? -held : held;

    state->n      = n;
    signals->n    = n;
    signals->L    = L;
    signals->rise = rise;
    signals->f    = f;
    signals->q1   = q1;
    signals->q2   = q2;
    signals->q    = q;
    return f;
}
