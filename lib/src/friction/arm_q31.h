// The constrained arm, Eq. (2), in Q31. arm_f32.h derives the equations.
//
//     F += (phi_d d + phi_g G) 2^-s     d = n - f and G Q31, coefficients Q28, products Q59
//     G  =  gamma_d d + gamma_g G       G, the change of F a tick, times 2^s
//
// F is held in 64 bits, Q59, so a drive far below one bit still moves it. G is rounded towards zero, without a carry: a
// sticking arm (d = 0) then reaches exact rest in finite time, equally from both signs. With a carry G would toggle by
// one bit for ever, which the relays would see as a rising net force. A tick has no loops and no divisions. Not
// synchronized: one state, one tick.

#ifndef TRIBO_FRICTION_ARM_Q31_H
#define TRIBO_FRICTION_ARM_Q31_H

#include "tribo/friction_q31.h"
#include "tribo/q31.h"

/// Does what tribo_arm_f32_init does, in Q31. Returns TRIBO_OK or a status of tribo_arm_f32_init. Also returns
/// TRIBO_ERR_ARM_TOO_FAST if gamma_d reaches 4, and TRIBO_ERR_DAMPING if the quantised arm is not stable.
tribo_status_t tribo_arm_q31_init(tribo_arm_q31_params_t       *params,
                                  const tribo_arm_f32_config_t *config,
                                  float                         sample_time_s);

/// F in Q31.
static inline int32_t tribo_arm_q31_force(const tribo_arm_q31_state_t *state)
{
    return (int32_t)tribo_q31_shift_to_zero(state->force, 28);
}

#define ARM_Q31_FRACTION 28u // fraction bits of the coefficients

/// Advances one sample with the drive `drive` = n - f in Q31: the net force that friction does not cancel.
static inline void arm_q31_step(const tribo_arm_q31_params_t *params, tribo_arm_q31_state_t *state, int32_t drive)
{
    const int32_t G      = state->force_change;
    const int64_t change = tribo_q31_multiply(params->phi_d, drive) + tribo_q31_multiply(params->phi_g, G);
    const int64_t next_G = tribo_q31_multiply(params->gamma_d, drive) + tribo_q31_multiply(params->gamma_g, G);

    // A corrupt F may wrap, so the sum is unsigned, which is defined. |F| is within full scale if the high word of F is
    // -2^27 to 2^27 - 1. One unsigned comparison tests both limits.
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
