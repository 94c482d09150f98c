// One sample of the arm, inline, for a drive that is known to be good.

#ifndef TRIBO_ARM_F32_KERNEL_H
#define TRIBO_ARM_F32_KERNEL_H

#include "tribo/arm_f32.h"

#include "exact_f32.h"
#include "usual.h"

/// F and G clamped to +-TRIBO_F32_FORCE_MAX_N and counted.
void tribo_arm_f32_clamp(tribo_arm_f32_state_t *state);

static inline float arm_f32_kernel(const tribo_arm_f32_params_t *params, tribo_arm_f32_state_t *state, float d)
{
    const float G    = state->force_change_n;
    const float F    = state->force_n + (params->phi_d * d + params->phi_g * G);
    const float next = params->gamma_d * d + params->gamma_g * G;

    state->force_n        = F;
    state->force_change_n = next;
    if (TRIBO_RARE(!(magnitude(F) + magnitude(next) <= TRIBO_F32_FORCE_MAX_N))) // one compare for both
    {
        tribo_arm_f32_clamp(state);
    }
    return state->force_n;
}

#endif
