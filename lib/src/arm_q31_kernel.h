// One sample of the arm, inline.

#ifndef TRIBO_ARM_Q31_KERNEL_H
#define TRIBO_ARM_Q31_KERNEL_H

#include "tribo/arm_q31.h"

#include "sum_q31.h"
#include "usual.h"

/// What makes a shift of x one towards zero; `below` are the bits that it drops.
static inline uint32_t arm_q31_up(int64_t x, uint32_t below)
{
    return (uint32_t)tribo_q31_sign(x) & below;
}

static inline void arm_q31_kernel(const tribo_arm_q31_params_t *params, tribo_arm_q31_state_t *state, int32_t drive)
{
    const int32_t   G      = state->force_change;
    const int64_t   change = tribo_q31_multiply(params->phi_d, drive) + tribo_q31_multiply(params->phi_g, G);
    const int64_t   next   = tribo_q31_multiply(params->gamma_d, drive) + tribo_q31_multiply(params->gamma_g, G);
    const int64_t   away   = change + arm_q31_up(change, params->below);
    const sum_q31_t moved  = sum_q31_of((uint32_t)(uint64_t)away, (uint32_t)((uint64_t)away >> 32));
    const sum_q31_t F =
        sum_q31_add_shifted(sum_q31_load(&state->force), moved, (pair_t){params->power, params->shift}, sum_q31_one());
    sum_q31_store(&state->force, F);
    if (sum_q31_is_beyond(F, 28))
    {
        tribo_q31_count(&state->saturated);
        state->force = (state->force < 0 ? -(int64_t)TRIBO_Q31_MAX : TRIBO_Q31_MAX) * (INT64_C(1) << 28);
    }
    state->force_change = tribo_q31_narrow(next + arm_q31_up(next, (UINT32_C(1) << 28) - 1u), 28, &state->saturated);
}

#endif
