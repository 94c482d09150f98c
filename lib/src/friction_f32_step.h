// One sample of the friction model, Eqs. (3) to (6), (8), (9), at a net force and an end-point force that are known to be
// good.

#ifndef TRIBO_FRICTION_F32_STEP_H
#define TRIBO_FRICTION_F32_STEP_H

#include "tribo/friction_f32.h"

#include "ieee_f32.h"
#include "relay_step.h"

#include <stddef.h>

/// L+ and L- at load |F| from the table.
void tribo_friction_f32_look_up(const tribo_friction_f32_params_t *params, float load_n, float L_n[2]);

/// L at load |F| by an affine law.
static inline float friction_f32_affine(const tribo_breakaway_f32_t *law, float load_n)
{
    return law->offset_n + law->slope * load_n;
}

/// 2^-x / 8 for x from 0; 2^-32 / 8 stands for what is smaller.
static inline float friction_f32_power(float x)
{
    const float   bounded  = x < 32.0f ? x : 32.0f;
    const int32_t whole    = (int32_t)bounded;
    const float   fraction = bounded - (float)whole;
    // 2^-fraction / 8, a minimax polynomial (tools/fit_friction.py); the whole part goes into the exponent.
    const float p =
        (((8.45881006e-04f * fraction - 6.63424947e-03f) * fraction + 2.99176286e-02f) * fraction - 8.66287739e-02f) *
            fraction +
        1.24999676e-01f;
    return from_bits_f32(bits_f32(p) - ((uint32_t)whole << 23));
}

/// The argument of Eq. (3), x = n/(k L), as the fraction N/D: k of Eq. (5) is one too, and so a tick divides once.
typedef struct
{
    float N, D;
} friction_f32_argument_t;

/// Eq. (5) is k = (k_max + k_min E)/(1 + E), E = e^(2 m (v/v0 - 1)) = 2^exponent. Above and below the line it is
/// multiplied by 2^-exponent where that is positive, so that nothing overflows: k = B/A with A = 1 + 2^-|exponent|.
static inline friction_f32_argument_t friction_f32_argument(const tribo_friction_f32_params_t *params,
                                                            float                              n,
                                                            float                              L,
                                                            float                              rise)
{
    const float exponent = params->exponent_per_rise * rise - params->exponent_at_rest;
    const float power    = friction_f32_power(magnitude(exponent));
    // A and B are an eighth of what they stand for, as only a k L of over 2,000 n underflows then; B is also 1.57 times
    // that, which makes a coefficient of Eq. (3) below 1.
    const float                         A = 0.125f + power;
    const tribo_friction_f32_k_t *const k = &params->k[less(exponent, 0.0f)];
    const float                         B = k->at_0 + k->per_power * power;
    return (friction_f32_argument_t){.N = n * A, .D = B * L};
}

/// Eq. (3) for n from 0 with Q, before the saturation: k L tanh(n/(k L)) = n (1 - R(x^2)), x = N/D. R is a rational
/// function (tools/fit_friction.py). It is 0 for N = 0, which leaves n: the case without Q.
static inline float friction_f32_curve(float n, friction_f32_argument_t x)
{
    const float N2          = x.N * x.N;
    const float D2          = x.D * x.D;
    const float numerator   = N2 * (0.822749458f * D2 + 0.0850677037f * N2);
    const float denominator = (D2 + N2) * (D2 + 0.0906026981f * N2);
    return n - n * (numerator / denominator);
}

static inline float friction_f32_step(const tribo_friction_f32_params_t *params,
                                      tribo_friction_f32_state_t        *state,
                                      float                              n,
                                      float                              force_n,
                                      tribo_friction_f32_signals_t      *signals)
{
    const float    n_before     = state->n_n;
    const float    size         = magnitude(n);
    const float    size_before  = magnitude(n_before);
    const float    rise         = size - size_before; // v h, Eq. (6)
    const uint32_t negative     = less(n, 0.0f);
    const uint32_t was_negative = less(n_before, 0.0f);
    const float    load         = magnitude(force_n);

    float L        = friction_f32_affine(&params->law[negative], load); // breakaway on the side of n
    float L_before = friction_f32_affine(&params->law[was_negative], load);
    if (params->table != NULL)
    {
        float both[2];
        tribo_friction_f32_look_up(params, load, both);
        L        = both[negative];
        L_before = both[was_negative];
    }

    // Stored early, to shorten their lives.
    state->n_n         = n;
    signals->n_n       = n;
    signals->L_n       = L;
    signals->v_n_per_s = rise * params->rate_hz;

    const uint32_t inside = less(size, params->set_level * L);
    const uint32_t deep   = less(params->reset_level * L_before, size_before);
    const uint32_t back   = less(rise, 0.0f) | (negative ^ was_negative);
    const uint32_t events = relay_events(negative, was_negative, inside, deep, back);
    const uint32_t relays = relay_step(&state->relay, params->pulse_width, events);
    const uint32_t Q      = relay_q(relays, negative, less(0.0f, rise));
    signals->relays       = (uint8_t)(relays | Q * TRIBO_RELAY_Q);

    const friction_f32_argument_t x      = friction_f32_argument(params, (float)Q * size, L, rise);
    const float                   curved = friction_f32_curve(size, x);
    const float                   held   = curved < L ? curved : L; // Eq. (4)
    const float                   f      = negative != 0u ? -held : held;
    signals->f_n                         = f;
    return f;
}

#endif
