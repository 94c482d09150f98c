// One sample of the constrained arm, Eq. (2): I theta'' = d - b theta' with the drive d = u + g - K theta - f. The exact
// solution for a d that is held over the sample, written in differences:
//
//     F += phi_d d + phi_g G        F = K theta, the end-point force
//     G  = gamma_d d + gamma_g G    G, the change of F in a sample at the present speed
//
// F appears on the right only inside d. So while friction holds the arm, d = 0 exactly, G decays and F stands still.

#ifndef TRIBO_ARM_F32_STEP_H
#define TRIBO_ARM_F32_STEP_H

#include "tribo/arm_f32.h"

#include "ieee_f32.h"

/// `drive_n` is d = n - f in N, finite: the part of the net force that friction does not cancel.
static inline void arm_f32_step(const tribo_arm_f32_params_t *params, tribo_arm_f32_state_t *state, float drive_n)
{
    const float G = state->force_change_n;

    float F      = state->force_n + (params->phi_d * drive_n + params->phi_g * G);
    float next_G = params->gamma_d * drive_n + params->gamma_g * G;
    // Beyond any credible force F was driven too far or the state is corrupt. Hold F at the limit, or at 0 for a NaN, and
    // stop the arm. A corrupt G needs no check of its own: it either drives F out of range here or decays.
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
