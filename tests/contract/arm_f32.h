// The f32 arm as the contract suite sees it: physical units in double.

#ifndef TESTS_CONTRACT_ARM_F32_H
#define TESTS_CONTRACT_ARM_F32_H

#include "friction/arm_f32.h"

#include <stddef.h>

#define ARM_TOLERANCE_N 2e-6 // of a step of 1 N
#define ARM_REST_N      1e-6

typedef struct
{
    tribo_arm_f32_params_t params;
    tribo_arm_f32_state_t  state;
} arm_t;

static inline tribo_status_t arm_init(arm_t *x, const tribo_arm_f32_config_t *config, double sample_time_s)
{
    tribo_arm_f32_reset(&x->state);
    return tribo_arm_f32_init(&x->params, config, (float)sample_time_s);
}

static inline double arm_force(const arm_t *x)
{
    return (double)x->state.force_n;
}

/// The change of F in a sample at the present speed.
static inline double arm_change(const arm_t *x)
{
    return (double)x->state.force_change_n;
}

static inline double arm_step(arm_t *x, double drive)
{
    return (double)tribo_arm_f32_step(&x->params, &x->state, (float)drive);
}

#endif
