#include "tribo/arm_q31.h"

#define FORCE_MAX ((int64_t)TRIBO_Q31_MAX * (INT64_C(1) << 28)) // full scale in Q59

void tribo_arm_q31_reset(tribo_arm_q31_state_t *state)
{
    state->force        = 0;
    state->force_change = 0;
    state->saturated    = 0;
}

int32_t tribo_arm_q31_step(const tribo_arm_q31_params_t *params, tribo_arm_q31_state_t *state, int32_t drive)
{
    const int64_t d = drive;
    const int64_t G = state->force_change;

    int64_t F = state->force + tribo_q31_shift_to_zero(params->phi_d * d + params->phi_g * G, params->shift);
    if (F > FORCE_MAX || F < -FORCE_MAX)
    {
        tribo_q31_count(&state->saturated);
        F = F < 0 ? -FORCE_MAX : FORCE_MAX;
    }
    state->force = F;

    const int64_t next  = tribo_q31_shift_to_zero(params->gamma_d * d + params->gamma_g * G, 28);
    state->force_change = tribo_q31_saturate(next, &state->saturated);
    return tribo_arm_q31_force(state);
}
