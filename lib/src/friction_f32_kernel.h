// One sample of the friction model, inline, for a net force and an end-point force that are known to be good.

#ifndef TRIBO_FRICTION_F32_KERNEL_H
#define TRIBO_FRICTION_F32_KERNEL_H

#include "tribo/friction_f32.h"

#include "exact_f32.h"
#include "relay_kernel.h"
#include "usual.h"

#include <stddef.h>

/// L+ and L- at load |F| from the table.
void tribo_friction_f32_look_up(const tribo_friction_f32_params_t *params, float load_n, float L_n[2]);

/// L at load |F| by an affine law.
static inline float friction_f32_affine(const tribo_breakaway_f32_t *law, float load_n)
{
    return law->offset_n + law->slope * load_n;
}

/// 2^-y / 8 of a magnitude given in bits; 2^-35 stands for what is below it.
static inline float friction_f32_power(uint32_t y_bits)
{
    const uint32_t most  = 0x42000000u; // 32: a constant within an instruction
    const float    y     = from_bits_f32(y_bits < most ? y_bits : most);
    const int32_t  whole = (int32_t)y;
    const float    f     = y - (float)whole;
    // A minimax polynomial (tools/fit_friction.py).
    const float p =
        (((8.45881006e-04f * f - 6.63424947e-03f) * f + 2.99176286e-02f) * f - 8.66287739e-02f) * f + 1.24999676e-01f;
    return from_bits_f32(bits_f32(p) - ((uint32_t)whole << 23));
}

/// Eq. (3) before the saturation, of a magnitude n: n (1 - R), tanh(x)/x = 1 - R(x^2), x = n/(k L), k = B/A. `n_of_q` is
/// +-n, or 0 without Q, for which R is 0.
static inline float friction_f32_curve(const tribo_friction_f32_params_t *params,
                                       float                              n,
                                       float                              n_of_q,
                                       float                              L,
                                       float                              rise)
{
    TRIBO_FROM_HERE();
    const float    y      = params->y_per_rise * rise - params->y_at_0;
    const uint32_t y_bits = bits_f32(y);
    const uint32_t below  = y_bits >> 31;
    const float    w      = friction_f32_power(y_bits & 0x7fffffffu);
    const float    A = 0.125f + w; // all over 8: only a k L of 2,000 n and more overflows below, where R is under 1e-7
    // B, and so D, is 1.57 times what it stands for, which makes a coefficient 1.
    const float B = params->k[below].at_0 + params->k[below].per_w * w;
    TRIBO_FROM_HERE();
    const float N       = n_of_q * A;
    const float D       = B * L;
    const float N2      = N * N;
    const float D2      = D * D;
    const float R_above = N2 * (0.822749458f * D2 + 0.0850677037f * N2); // tools/fit_friction.py
    const float R_below = (D2 + N2) * (D2 + 0.0906026981f * N2);
    return n - n * (R_above / R_below);
}

/// `any` is false, a constant, where there is no table.
static inline float friction_f32_kernel(const tribo_friction_f32_params_t *params,
                                        tribo_friction_f32_state_t        *state,
                                        float                              n,
                                        float                              force_n,
                                        tribo_friction_f32_signals_t      *signals,
                                        bool                               any)
{
    const float    n_before    = state->n_n;
    const uint32_t n_bits      = bits_f32(n);
    const uint32_t before_bits = bits_f32(n_before);
    const uint32_t side        = n_bits >> 31;
    const uint32_t side_before = before_bits >> 31;
    const float    load_n      = magnitude(force_n);
    const float    size        = magnitude(n);
    const float    size_before = magnitude(n_before);

    float L;
    float reset;
    if (any && params->table != NULL)
    {
        float both[2];
        tribo_friction_f32_look_up(params, load_n, both);
        L     = both[side];
        reset = params->reset_level * both[side_before];
    }
    else
    {
        L     = friction_f32_affine(&params->law[side], load_n);
        reset = friction_f32_affine(&params->reset[side_before], load_n);
    }
    const float rise = size - size_before;

    // As early as can be, so that what comes does not have to keep it.
    state->n_n         = n;
    signals->n_n       = n;
    signals->L_n       = L;
    signals->v_n_per_s = rise * params->rate_hz;

    const uint32_t inside = bits_f32(size - params->set_level * L);
    const uint32_t deep   = bits_f32(reset - size_before);
    const uint32_t back   = bits_f32(rise) | (n_bits ^ before_bits);
    const uint32_t relays =
        relay_kernel(&state->relay, params->pulse_width, friction_relay_events(side, side_before, inside, deep, back));
    // Q of the side of n, where |n| rises; that is never -0.
    const uint32_t q = relay_armed_rise(relays, side, bits_f32(rise));

    signals->relays = (uint8_t)(relays | (q & TRIBO_RELAY_Q));

    const float n_of_q = from_bits_f32(n_bits & q); // a mask, so that a tick costs the same on either branch
    const float curved = friction_f32_curve(params, size, n_of_q, L, rise);
    const float held   = curved < L ? curved : L;
    const float f      = side != 0u ? -held : held;

    signals->f_n = f;
    return f;
}

#endif
