// LuGre friction of a constrained arm, single precision, the paper's Eq. (12) with F_C = F_S = L(F):
//
//     f = sat( s0 z + s1 dz/dt + s2 w )       dz/dt = w - s0 |w| z / L       sat(x) = min(L+, max(-L-, x))
//
// The rival of friction_f32.h, with the same step: u and F in, f out, L(F) and gravity from the friction's params. s1/I is
// 2.6e6 1/s with the paper's parameters, so an explicit step of w and z must stay below 0.7 us. Here steps of any length are
// stable:
//
//     w at the step's end by the arm's zero-order hold with f held, linear in f
//     z by backward Euler, z1 = (z + h w1) / D,  D = 1 + s0 h |w1| / L
//
// f comes from a linear equation instead of a quadratic one, with the D* of a sticking arm; f beyond L indicates a sliding
// arm. In numbers, with Z = s0 z and r = n - f plus the momentum carried over by the arm (G = gamma_d r; G, gamma_d, gamma_g:
// arm_f32.h):
//
//     n' = n + gamma_g r[k-1]                    the force that friction must hold
//     D* = 1 + |n' - Z| c/(1 + a + b) / L        a = (1 + beta) c,  beta = s1/(s0 h),  b = s2 gamma_d/(K h)
//     P  = ((1 + beta)/D* - beta) Z              c = s0 gamma_d/K
//     f  = sat( n' - (n' - P) / (1 + b + a/D*) ),   r = n' - f
//     Z  = (Z + c r) / (1 + c |r|/L)
//
// |f| <= L and |Z| <= the largest L so far, for any input. A corrupt Z or r restarts from 0. The module computes its own speed,
// so its f must drive the config's arm. Against Eq. (12) by CVODE, with the paper's parameters at 1 kHz and ramps of up to
// 0.4 N/s: F of that arm within 0.1 %, f within 0.1 % of L rms (tests/truth/test_lugre_compensator.c holds 1 %).
// Source: C. Canudas de Wit et al., IEEE Trans. Automatic Control 40(3), 1995; the linearly implicit step after V. Acary,
// B. Brogliato, Numerical Methods for Nonsmooth Dynamical Systems, 2008 (implicit time stepping), and, for sampled LuGre,
// L. Freidovich et al., "LuGre-model-based friction compensation", IEEE Trans. Control Systems Technology 18(1), 2010.
// Three divisions, no loops; with a breakaway table one more, and a loop over its points. Not synchronized: one state, one tick.
//
// The caller of a step has checked that F is finite.

#ifndef TRIBO_FRICTION_LUGRE_F32_H
#define TRIBO_FRICTION_LUGRE_F32_H

#include "tribo/friction_f32.h"

#include "../number/ieee_f32.h"
#include "law_f32.h"

/// Above any net force plus the arm's momentum; beyond it the state is corrupt.
#define LUGRE_F32_MAX_N 1.0e12f

/// L+ and L- at the end-point force.
static inline void lugre_f32_breakaway(const tribo_friction_f32_params_t *friction, float force_n, float L_n[2])
{
    const float load = magnitude(force_n);
    if (friction->table_length > 0u)
    {
        tribo_friction_f32_look_up(friction, load, L_n);
    }
    else
    {
        L_n[0] = friction_f32_affine(&friction->law[0], load);
        L_n[1] = friction_f32_affine(&friction->law[1], load);
    }
}

/// f for the net force `n` and the end-point force `force_n`; Z and r advance by one sample.
static inline float lugre_f32_step(const tribo_lugre_f32_params_t    *params,
                                   const tribo_friction_f32_params_t *friction,
                                   tribo_lugre_f32_state_t           *state,
                                   float                              n,
                                   float                              force_n,
                                   tribo_friction_f32_signals_t      *signals)
{
    float both[2];
    lugre_f32_breakaway(friction, force_n, both);
    const float positive = both[0];
    const float negative = both[1];
    float       carried  = n + params->gamma_g * state->drive_n; // n'
    float       Z        = state->bristle_n;
    if (exceeds(carried, LUGRE_F32_MAX_N) || exceeds(Z, LUGRE_F32_MAX_N))
    {
        carried = 0.0f;
        Z       = 0.0f;
    }

    // The linear equation for f, with the D of a sticking arm.
    const float stretch = carried - Z;
    const float L_stuck = stretch >= 0.0f ? positive : negative;
    const float inverse = L_stuck / (L_stuck + params->stuck * magnitude(stretch)); // 1/D*
    const float pull    = ((1.0f + params->beta) * inverse - params->beta) * Z;     // P
    float       r       = (carried - pull) / (params->b_and_1 + params->a * inverse);
    float       f       = carried - r;
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

    // The bristles after the motion that results from f; L is for its direction.
    const float L    = r >= 0.0f ? positive : negative;
    const float path = params->c * r;
    state->bristle_n = (Z + path) * (L / (L + magnitude(path)));
    state->drive_n   = r;
    state->n_n       = n;

    *signals = (tribo_friction_f32_signals_t){.n_n = n, .L_n = f >= 0.0f ? positive : negative, .f_n = f};
    return f;
}

#endif
