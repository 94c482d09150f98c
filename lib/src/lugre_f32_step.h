// One sample of LuGre friction, Eq. (12); lugre_f32.h derives the form. The caller has checked that F is finite.

#ifndef TRIBO_LUGRE_F32_STEP_H
#define TRIBO_LUGRE_F32_STEP_H

#include "tribo/lugre_f32.h"

#include "friction_f32_step.h"
#include "ieee_f32.h"

/// Above any net force and what an arm carries over; beyond it the state is corrupt.
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

    // The linear equation for f, with the D of an arm that sticks.
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

    // The bristles with the motion that this f leaves; L is that of its direction.
    const float L    = r >= 0.0f ? positive : negative;
    const float path = params->c * r;
    state->bristle_n = (Z + path) * (L / (L + magnitude(path)));
    state->drive_n   = r;
    state->n_n       = n;

    *signals = (tribo_friction_f32_signals_t){.n_n = n, .L_n = f >= 0.0f ? positive : negative, .f_n = f};
    return f;
}

#endif
