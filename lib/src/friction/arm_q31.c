#include "arm_q31.h"

#include "tribo/friction_f32.h"

#include "../number/fixed_q31.h"
#include "arm_f32.h"

#include <stddef.h>

#define ARM_MAX 3.999f // limit of the coefficients

static int64_t lesser(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/// Checks Jury's conditions on the quantised numbers: for the arm that moves under a constant force, and for G alone
/// while the arm sticks. For a slow arm the conditions are small differences, so nothing is rounded before subtracting.
static bool arm_is_stable(const tribo_arm_q31_params_t *p)
{
    const int64_t one      = INT64_C(1) << 28;
    const int64_t coupling = (int64_t)p->phi_g * p->gamma_d; // Q(56 + s)
    const int64_t at_one   = p->phi_d * (one - p->gamma_g) + coupling;
    const int64_t radius   = (one - p->gamma_g) * (INT64_C(1) << p->shift) +
                           tribo_q31_shift_to_zero((int64_t)p->phi_d * p->gamma_g - coupling, 28);
    const int64_t phi_d        = tribo_q31_shift_to_zero(p->phi_d, p->shift);
    const int64_t at_minus_one = (2 * one - phi_d) * (one + p->gamma_g) + tribo_q31_shift_to_zero(coupling, p->shift);
    const int64_t sticking     = one - (int64_t)tribo_q31_magnitude(p->gamma_g);
    return lesser(lesser(at_one, at_minus_one), lesser(radius, sticking)) > 0;
}

tribo_status_t tribo_arm_q31_init(tribo_arm_q31_params_t       *params,
                                  const tribo_arm_f32_config_t *config,
                                  float                         sample_time_s)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_arm_f32_params_t f32;
    const tribo_status_t   status = tribo_arm_f32_init(&f32, config, sample_time_s);
    if (status != TRIBO_OK)
    {
        return status;
    }
    // gamma_d is about (omega h)^2. Scaling G by 2^shift, about 1/(omega h), gives drive and speed coefficients of
    // similar size. phi_d is at most 2 and phi_g at most 1, so the coefficients of F stay below 4 together and the sum
    // of their products below 2^61.
    const float push  = magnitude(f32.gamma_d);
    const float move  = magnitude(f32.phi_d);
    const float coast = magnitude(f32.phi_g);
    int32_t     shift = 0;
    while (shift < 15 && scaled(push, 2 * (shift + 1)) <= 1.0f && scaled(move, shift + 1) + coast < ARM_MAX)
    {
        shift++;
    }
    if (!(scaled(push, shift) < ARM_MAX))
    {
        return TRIBO_ERR_ARM_TOO_FAST;
    }
    const tribo_arm_q31_params_t made = {.phi_d   = fixed(scaled(f32.phi_d, shift), 28),
                                         .phi_g   = fixed(f32.phi_g, 28),
                                         .gamma_d = fixed(scaled(f32.gamma_d, shift), 28),
                                         .gamma_g = fixed(f32.gamma_g, 28),
                                         .shift   = (uint8_t)shift};
    if (!arm_is_stable(&made))
    {
        return TRIBO_ERR_DAMPING;
    }
    *params = made;
    return TRIBO_OK;
}

void tribo_arm_q31_reset(tribo_arm_q31_state_t *state)
{
    state->force        = 0;
    state->force_change = 0;
    state->saturated    = 0;
}

int32_t tribo_arm_q31_step(const tribo_arm_q31_params_t *params, tribo_arm_q31_state_t *state, int32_t drive)
{
    arm_q31_step(params, state, drive);
    return tribo_arm_q31_force(state);
}
