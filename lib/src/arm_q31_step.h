// One sample of the constrained arm, Eq. (2), as in arm_f32_step.h:
//
//     F += (phi_d d + phi_g G) 2^-s     F in 64 bits, Q59; coefficients Q28, d and G Q31, products Q59
//     G  = gamma_d d + gamma_g G        G times 2^s in Q31, rounded towards zero
//
// F keeps the bits below Q31, so a slow arm still moves. G is rounded towards zero without a carry: while the arm sticks
// (d = 0) it reaches 0 in finite time, and from both sides alike.

#ifndef TRIBO_ARM_Q31_STEP_H
#define TRIBO_ARM_Q31_STEP_H

#include "tribo/arm_q31.h"

#define ARM_Q31_FRACTION 28u // of the coefficients

/// `drive` is d = n - f in Q31: the part of the net force that friction does not cancel.
static inline void arm_q31_step(const tribo_arm_q31_params_t *params, tribo_arm_q31_state_t *state, int32_t drive)
{
    const int32_t G      = state->force_change;
    const int64_t change = tribo_q31_multiply(params->phi_d, drive) + tribo_q31_multiply(params->phi_g, G);
    const int64_t next_G = tribo_q31_multiply(params->gamma_d, drive) + tribo_q31_multiply(params->gamma_g, G);

    // A corrupt F may wrap: the sum is unsigned, which is defined. F is in range when its high word is -2^27 to 2^27 - 1,
    // i.e. |F| within full scale; one unsigned comparison tests both ends.
    int64_t        F    = (int64_t)((uint64_t)state->force + (uint64_t)tribo_q31_shift_to_zero(change, params->shift));
    const uint32_t high = (uint32_t)((uint64_t)F >> 32);
    if (high + (UINT32_C(1) << 27) >= UINT32_C(1) << 28)
    {
        F = (F < 0 ? -(int64_t)TRIBO_Q31_MAX : TRIBO_Q31_MAX) * (INT64_C(1) << ARM_Q31_FRACTION);
        tribo_q31_count(&state->saturated);
    }
    state->force = F;
    state->force_change =
        tribo_q31_narrow(next_G + tribo_q31_up(next_G, ARM_Q31_FRACTION), ARM_Q31_FRACTION, &state->saturated);
}

#endif
