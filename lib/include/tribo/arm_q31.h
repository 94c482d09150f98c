/// The constrained arm, Eq. (2), in Q31.
///
///     F += (phi_d d + phi_g G) 2^-s        d = n - f, the drive
///     G  =  gamma_d d + gamma_g G          G, the change of F a tick, times 2^s
///
/// F is held in 64 bits, Q59, so nothing that it accumulates is lost. G decays and is rounded towards zero, on purpose
/// without a carry: an arm that sticks comes to rest in a finite time, exactly, from both sides alike. (With a
/// carry it would toggle by one bit for ever, and the relays would take that for a rising net force.)
/// No loops, no divisions. Not synchronized: one state, one tick.

#ifndef TRIBO_ARM_Q31_H
#define TRIBO_ARM_Q31_H

#include "tribo/q31.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// What a step reads, made by the functions of quantize_q31.h.
typedef struct
{
    int32_t phi_d, phi_g;     ///< Q28, together within +-4; phi_d with the 2^s of G in it
    int32_t gamma_d, gamma_g; ///< Q28, within +-4; gamma_d with the 2^s of G in it
    uint8_t shift;            ///< s, 0 to 15
} tribo_arm_q31_params_t;

typedef struct
{
    int64_t  force;        ///< F = K theta, Q59
    int32_t  force_change; ///< G 2^s, Q31
    uint32_t saturated;    ///< F or G clamped since reset; stops at UINT32_MAX
} tribo_arm_q31_state_t;

/// At rest at F = 0, counter 0.
void tribo_arm_q31_reset(tribo_arm_q31_state_t *state);

/// F in Q31.
static inline int32_t tribo_arm_q31_force(const tribo_arm_q31_state_t *state)
{
    return (int32_t)tribo_q31_shift_to_zero(state->force, 28);
}

/// Advances one sample with the drive n - f, Q31, held, and returns the new F in Q31. Cannot fail.
int32_t tribo_arm_q31_step(const tribo_arm_q31_params_t *params, tribo_arm_q31_state_t *state, int32_t drive);

#ifdef __cplusplus
}
#endif

#endif
