// One sample of the arm, inline, for a drive that is known to be good.

#ifndef TRIBO_ARM_F32_KERNEL_H
#define TRIBO_ARM_F32_KERNEL_H

#include "tribo/arm_f32.h"

#include "exact_f32.h"
#include "usual.h"

static inline float arm_f32_kernel(const tribo_arm_f32_params_t *params, tribo_arm_f32_state_t *state, float d)
{
    const float G    = state->force_change_n;
    float       next = params->gamma_d * d + params->gamma_g * G;
    float       F    = state->force_n + (params->phi_d * d + params->phi_g * G);
    if (TRIBO_RARE(exceeds(F, TRIBO_F32_FORCE_MAX_N))) // a lost G takes F with it, or dies away
    {
        F    = F < 0.0f ? -TRIBO_F32_FORCE_MAX_N : TRIBO_F32_FORCE_MAX_N;
        next = 0.0f;
        count(&state->clamped);
    }
    state->force_n        = F;
    state->force_change_n = next;
    return F;
}

#endif
