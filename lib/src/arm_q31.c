#include "tribo/arm_q31.h"

#define FORCE_MAX ((int64_t)TRIBO_Q31_MAX * (INT64_C(1) << 28)) // full scale in Q59

void tribo_arm_q31_reset(tribo_arm_q31_state_t *state)
{
    state->force        = 0;
    state->force_change = 0;
    state->saturated    = 0;
}

/// tribo_q31_shift_to_zero for shifts up to 31, in words.
static inline int64_t short_shift_to_zero(int64_t x, uint32_t shift)
{
    const uint32_t up = (0u - (uint32_t)(x < 0)) & ((UINT32_C(1) << shift) - 1u);
    return tribo_q31_shift(x + up, shift);
}

int32_t tribo_arm_q31_step(const tribo_arm_q31_params_t *params, tribo_arm_q31_state_t *state, int32_t drive)
{
    const int32_t d = drive;
    const int32_t G = state->force_change;

    int64_t F =
        state->force +
        short_shift_to_zero(tribo_q31_multiply(params->phi_d, d) + tribo_q31_multiply(params->phi_g, G), params->shift);
    if (F > FORCE_MAX || F < -FORCE_MAX)
    {
        tribo_q31_count(&state->saturated);
        F = F < 0 ? -FORCE_MAX : FORCE_MAX;
    }
    state->force = F;

    const int64_t next =
        tribo_q31_shift_to_zero(tribo_q31_multiply(params->gamma_d, d) + tribo_q31_multiply(params->gamma_g, G), 28);
    state->force_change = tribo_q31_saturate(next, &state->saturated);
    return tribo_arm_q31_force(state);
}
