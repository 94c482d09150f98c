// The constrained arm, Eq. (2), single precision, with F = K theta:
//
//     I theta'' = u + g - K theta - b theta' - f
//
// With the net force n = u - F + g the drive is d = n - f, which is exactly 0 while the arm sticks. For a d held over a
// sample this is the exact solution. It is written in differences, which keeps all digits at a short sample time:
//
//     F += phi_d d + phi_g G        F, the end-point force, N
//     G  = gamma_d d + gamma_g G    G, the change of F in a sample at the present speed
//
// F appears on the right only inside d, so while friction holds the arm F is constant and G decays. F stays within
// +-TRIBO_F32_FORCE_MAX_N and recovers after clamping or corruption: clamping sets G to 0, and a NaN sets F to 0, too.
// A tick has no loops and no divisions. Not synchronized: one state, one tick.

#ifndef TRIBO_FRICTION_ARM_F32_H
#define TRIBO_FRICTION_ARM_F32_H

#include "tribo/friction_f32.h"
#include "tribo/status.h"

#include "../number/ieee_f32.h"

/// Checks `config` and discretises it. Returns TRIBO_OK, TRIBO_ERR_NULL or the status of the first wrong field. Writes
/// nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_arm_f32_init(tribo_arm_f32_params_t       *params,
                                  const tribo_arm_f32_config_t *config,
                                  float                         sample_time_s);

/// Advances one sample with the drive `drive_n` = n - f, which must be finite: the net force that friction does not
/// cancel.
static inline void arm_f32_step(const tribo_arm_f32_params_t *params, tribo_arm_f32_state_t *state, float drive_n)
{
    const float G = state->force_change_n;

    float F      = state->force_n + (params->phi_d * drive_n + params->phi_g * G);
    float next_G = params->gamma_d * drive_n + params->gamma_g * G;
    // If F is beyond any credible force, it was driven too far or the state is corrupt. Hold F at the limit, or at 0
    // for a NaN, and stop the arm. A corrupt G needs no check: it either drives F out of range here or decays.
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
