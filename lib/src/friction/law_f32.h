// One sample of the friction model, Eqs. (3) to (6), (8) and (9). The caller has checked that n and F are finite.
//
// The model works on magnitudes and on the sign bit of n, 0 for n >= 0 and 1 for n < 0, which also selects L+ or L-.
// The sign is put back at the end, so f(-u, -F) = -f(u, F) holds exactly.

#ifndef TRIBO_FRICTION_LAW_F32_H
#define TRIBO_FRICTION_LAW_F32_H

#include "tribo/friction_f32.h"

#include "../number/ieee_f32.h"
#include "relay.h"

#include <stddef.h>

/// L+ and L- at load |F| from the breakaway table, linear between the points and constant beyond the first and the
/// last.
void tribo_friction_f32_look_up(const tribo_friction_f32_params_t *params, float load_n, float L_n[2]);

/// Sets only the affine breakaways and gravity, for a method that reads nothing else. Returns TRIBO_OK or the status of
/// the first bad one.
tribo_status_t tribo_friction_f32_init_law(tribo_friction_f32_params_t       *params,
                                           const tribo_friction_f32_config_t *config);

/// Refuses a number of point `index`: the one that `status`, TRIBO_ERR_TABLE_FORCE to TRIBO_ERR_TABLE_NEGATIVE, names.
tribo_status_t tribo_friction_f32_refuse_point(tribo_status_t                     status,
                                               const tribo_friction_f32_config_t *config,
                                               uint32_t                           index);

/// Breakaway at load |F| by the affine law: L = offset + slope |F|.
static inline float friction_f32_affine(const tribo_breakaway_f32_t *law, float load_n)
{
    return law->offset_n + law->slope * load_n;
}

/// 2^-x / 8 for x >= 0. From x = 32 on the result stays at 2^-32 / 8, which costs k a relative error of at most 2.3e-7.
/// A NaN counts as 32.
static inline float friction_f32_power(float x)
{
    const float   bounded  = x < 32.0f ? x : 32.0f;
    const int32_t whole    = (int32_t)bounded;
    const float   fraction = bounded - (float)whole;
    // 2^-fraction / 8 by a minimax polynomial of degree 4 (research/fit_friction.py). The whole part is then subtracted
    // from the exponent field: an exact division by 2^whole.
    const float p =
        (((8.45881006e-04f * fraction - 6.63424947e-03f) * fraction + 2.99176286e-02f) * fraction - 8.66287739e-02f) *
            fraction +
        1.24999676e-01f;
    return from_bits_f32(bits_f32(p) - ((uint32_t)whole << 23));
}

/// The argument of Eq. (3), x = n/(k L), as a fraction N/D. k of Eq. (5) is a fraction as well, so the tick needs a
/// single division.
typedef struct
{
    float N, D;
} friction_f32_argument_t;

/// Eq. (5) as a logistic curve: k = (k_max + k_min E)/(1 + E) with E = e^(2 m (v/v0 - 1)) = 2^exponent. At a slow rise
/// E is small and k near k_max; at a fast rise k tends to k_min. With p = 2^-|exponent| <= 1 neither form can overflow:
///
///     exponent >= 0:  k = (k_min + k_max p)/(1 + p)     both multiplied by 1/E = p
///     exponent <  0:  k = (k_max + k_min p)/(1 + p)     E = p
///
/// So k = B/A, and x = n/(k L) = n A/(B L).
static inline friction_f32_argument_t friction_f32_argument(const tribo_friction_f32_params_t *params,
                                                            float                              n,
                                                            float                              L,
                                                            float                              rise)
{
    const float exponent = params->exponent_per_rise * rise - params->exponent_at_rest;
    const float power    = friction_f32_power(magnitude(exponent));
    // A and B carry a factor of 1/8, which cancels; it keeps D^4 in the curve below FLT_MAX. A product underflows only
    // where k L exceeds 2,000 n, and there R is below half a unit in the last place. B also carries 1.57, which makes
    // one coefficient of the curve 1.
    const float                         A = 0.125f + power;
    const tribo_friction_f32_k_t *const k = &params->k[less(exponent, 0.0f)];
    const float                         B = k->at_0 + k->per_power * power;
    return (friction_f32_argument_t){.N = n * A, .D = B * L};
}

/// Eq. (3) for n >= 0, before saturation: k L tanh(n/(k L)) = n (1 - R(x^2)) with x = N/D. R is a rational function
/// (research/fit_friction.py), multiplied by D^4 above and below the line and fitted up to breakaway, f = L; beyond it
/// the result stays above L and Eq. (4) clamps it. N = 0 gives R = 0 and f = n, which is the branch of Eq. (3) without
/// Q.
static inline float friction_f32_curve(float n, friction_f32_argument_t x)
{
    const float N2          = x.N * x.N;
    const float D2          = x.D * x.D;
    const float numerator   = N2 * (0.822749458f * D2 + 0.0850677037f * N2);
    const float denominator = (D2 + N2) * (D2 + 0.0906026981f * N2);
    return n - n * (numerator / denominator);
}

/// Net force n = u - F + g.
static inline float friction_f32_net_force(const tribo_friction_f32_params_t *params,
                                           const tribo_friction_f32_state_t  *state,
                                           float                              u_n,
                                           float                              force_n)
{
    (void)state; // holds a counter in Q31 only
    return u_n - force_n + params->gravity_n;
}

/// f for the net force `n` and the end-point force `force_n`. The relays and n[k-1] advance by one sample.
static inline float friction_f32_step(const tribo_friction_f32_params_t *params,
                                      tribo_friction_f32_state_t        *state,
                                      float                              n,
                                      float                              force_n,
                                      tribo_friction_f32_signals_t      *signals)
{
    const float    n_before     = state->n_n;
    const uint32_t negative     = less(n, 0.0f);
    const uint32_t was_negative = less(n_before, 0.0f);
    const float    load         = magnitude(force_n);

    // Each comparator of the relays uses the breakaway of its own sign: L for that of n, L_before for that of n[k-1].
    float L        = friction_f32_affine(&params->law[negative], load);
    float L_before = friction_f32_affine(&params->law[was_negative], load);
    if (params->table_length > 0u)
    {
        float both[2];
        tribo_friction_f32_look_up(params, load, both);
        L        = both[negative];
        L_before = both[was_negative];
    }
    const float size        = magnitude(n);
    const float size_before = magnitude(n_before);
    const float rise        = size - size_before; // v h, Eq. (6)

    state->n_n         = n;
    signals->n_n       = n;
    signals->L_n       = L;
    signals->v_n_per_s = rise * params->rate_hz;

    // Eq. (9) and the reset rule of Fig. 5: `deep` uses n[k-1], so that one large step out of the deep region still
    // counts.
    const uint32_t inside = less(size, params->set_level * L);
    const uint32_t deep   = less(params->reset_level * L_before, size_before);
    const uint32_t back   = less(rise, 0.0f) | (negative ^ was_negative);
    const uint32_t events = relay_events(negative, was_negative, inside, deep, back);
    const uint32_t relays = relay_step(&state->relay, params->pulse_width, events);
    const uint32_t Q      = relay_q(relays, negative, less(size_before, size));
    signals->relays       = (uint8_t)(relays | Q * TRIBO_RELAY_Q);

    // Eq. (3): without Q the argument is 0 and the curve is n itself. Eq. (4) then limits f to breakaway.
    const friction_f32_argument_t x      = friction_f32_argument(params, (float)Q * size, L, rise);
    const float                   curved = friction_f32_curve(size, x);
    const float                   held   = curved < L ? curved : L;
    const float                   f      = negative != 0u ? -held : held;
    signals->f_n                         = f;
    return f;
}

#endif
