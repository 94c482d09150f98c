// One sample of the arm, Eq. (2), in differences (arm_q31.h says why, and how it comes to rest).

#ifndef TRIBO_ARM_Q31_STEP_H
#define TRIBO_ARM_Q31_STEP_H

#include "tribo/arm_q31.h"

#define ARM_Q31_FRACTION 28u // of the coefficients

/// `drive` is n - f, what is left of the net force once friction has taken its part.
static inline void arm_q31_step(const tribo_arm_q31_params_t *params, tribo_arm_q31_state_t *state, int32_t drive)
{
    const int32_t G      = state->force_change;
    const int64_t change = tribo_q31_multiply(params->phi_d, drive) + tribo_q31_multiply(params->phi_g, G);
    const int64_t next_G = tribo_q31_multiply(params->gamma_d, drive) + tribo_q31_multiply(params->gamma_g, G);

    // Q59 + Q59, unsigned, as a corrupt F may wrap. What fits Q59 has a high word from -2^27 to 2^27 - 1.
    int64_t        F    = (int64_t)((uint64_t)state->force + (uint64_t)tribo_q31_shift_to_zero(change, params->shift));
    const uint32_t high = (uint32_t)((uint64_t)F >> 32);
    if (high + (UINT32_C(1) << 27) >= UINT32_C(1) << 28)
    {
        F = (state->force < 0 ? -(int64_t)TRIBO_Q31_MAX : TRIBO_Q31_MAX) * (INT64_C(1) << ARM_Q31_FRACTION);
        tribo_q31_count(&state->saturated);
    }
    state->force = F;
    state->force_change =
        tribo_q31_narrow(next_G + tribo_q31_up(next_G, ARM_Q31_FRACTION), ARM_Q31_FRACTION, &state->saturated);
}

#endif
