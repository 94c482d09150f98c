// The Q31 arm as the contract suite sees it: physical units in double, at a full scale of 2 N or what the build says.

#ifndef TESTS_CONTRACT_ARM_Q31_H
#define TESTS_CONTRACT_ARM_Q31_H

#include "friction/arm_f32.h"
#include "friction/arm_q31.h"

#include <math.h>
#include <stddef.h>

#ifndef FULL_SCALE_N
#define FULL_SCALE_N 2.0
#endif
#define ARM_TOLERANCE_N 2e-6 // of a step of 1 N
#define ARM_REST_N      6e-8 // 64 bits

typedef struct
{
    tribo_arm_q31_params_t params;
    tribo_arm_q31_state_t  state;
} arm_t;

static inline tribo_status_t arm_init(arm_t *x, const tribo_arm_f32_config_t *config, double sample_time_s)
{
    tribo_arm_q31_reset(&x->state);
    return tribo_arm_q31_init(&x->params, config, (float)sample_time_s);
}

static inline double arm_force(const arm_t *x)
{
    return tribo_arm_q31_force(&x->state) / 2147483648.0 * FULL_SCALE_N;
}

/// The change of F in a sample at the present speed.
static inline double arm_change(const arm_t *x)
{
    return ldexp((double)x->state.force_change, -31 - x->params.shift) * FULL_SCALE_N;
}

/// A drive beyond full scale shows as full scale.
static inline double arm_step(arm_t *x, double drive)
{
    const double  q = round(drive / FULL_SCALE_N * 2147483648.0);
    const int32_t force =
        tribo_arm_q31_step(&x->params, &x->state, (int32_t)fmin(2147483647.0, fmax(-2147483647.0, q)));
    return force / 2147483648.0 * FULL_SCALE_N;
}

#endif
