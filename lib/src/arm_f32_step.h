// One sample of the arm, Eq. (2), for a drive that is known to be good: the exact zero-order-hold solution, in differences
// (arm_f32.h says why).

#ifndef TRIBO_ARM_F32_STEP_H
#define TRIBO_ARM_F32_STEP_H

#include "tribo/arm_f32.h"

#include "ieee_f32.h"

/// `drive_n` is n - f, what is left of the net force once friction has taken its part.
static inline void arm_f32_step(const tribo_arm_f32_params_t *params, tribo_arm_f32_state_t *state, float drive_n)
{
    const float G = state->force_change_n;

    float F      = state->force_n + (params->phi_d * drive_n + params->phi_g * G);
    float next_G = params->gamma_d * drive_n + params->gamma_g * G;
    // Beyond any force there is: F was driven there and is held at the limit, or the state is corrupt, and a NaN starts
    // again from 0. With G = 0 it recovers; a corrupt G either takes F here or decays.
    if (exceeds(F, TRIBO_F32_FORCE_MAX_N))
    {
        F      = F < 0.0f ? -TRIBO_F32_FORCE_MAX_N : F > 0.0f ? TRIBO_F32_FORCE_MAX_N : 0.0f;
        next_G = 0.0f;
        count(&state->clamped);
    }
    state->force_n        = F;
    state->force_change_n = next_G;
}

#endif
