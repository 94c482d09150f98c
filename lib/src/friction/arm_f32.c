#include "arm_f32.h"

#include "tribo/friction_f32.h"

#include "../number/ranges.h"

#include <stddef.h>

#define ROW(...) PARAMETERS_ROW(tribo_arm_f32_config_t, __VA_ARGS__)
const tribo_parameter_t tribo_arm_parameters[] = {TRIBO_ARM_PARAMETERS(ROW)};
#undef ROW

typedef struct
{
    float a11, a12, a21, a22;
} matrix_t;

static matrix_t multiply(matrix_t a, matrix_t b)
{
    return (matrix_t){a.a11 * b.a11 + a.a12 * b.a21,
                      a.a11 * b.a12 + a.a12 * b.a22,
                      a.a21 * b.a11 + a.a22 * b.a21,
                      a.a21 * b.a12 + a.a22 * b.a22};
}

static matrix_t scale(matrix_t a, float by)
{
    return (matrix_t){a.a11 * by, a.a12 * by, a.a21 * by, a.a22 * by};
}

static matrix_t add(matrix_t a, matrix_t b)
{
    return (matrix_t){a.a11 + b.a11, a.a12 + b.a12, a.a21 + b.a21, a.a22 + b.a22};
}

/// e^A - 1 by a Taylor series of A / 2^m, then m doublings e^2A - 1 = (e^A - 1)^2 + 2 (e^A - 1). Computing the
/// difference from 1 keeps the digits of a short sample time, at which e^A is close to 1.
static matrix_t exponential_minus_one(matrix_t a)
{
    const float norm     = magnitude(a.a11) + magnitude(a.a12) + magnitude(a.a21) + magnitude(a.a22);
    uint32_t    doubling = 0;
    float       shrink   = 1.0f;
    while (norm * shrink > 0.5f)
    {
        shrink *= 0.5f;
        doubling++;
    }

    const matrix_t x    = scale(a, shrink);
    matrix_t       term = x;
    matrix_t       sum  = x;
    for (uint32_t i = 2; i <= 8u; i++)
    {
        term = scale(multiply(term, x), 1.0f / (float)i);
        sum  = add(sum, term);
    }
    for (; doubling > 0u; doubling--)
    {
        sum = add(multiply(sum, sum), scale(sum, 2.0f));
    }
    return sum;
}

tribo_status_t tribo_arm_f32_init(tribo_arm_f32_params_t       *params,
                                  const tribo_arm_f32_config_t *config,
                                  float                         sample_time_s)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    if (!sample_time_ok(sample_time_s))
    {
        return TRIBO_ERR_SAMPLE_TIME;
    }
    const tribo_status_t status = PARAMETERS_CHECK(tribo_arm_parameters, config);
    if (status != TRIBO_OK)
    {
        return status;
    }
    // In a tick F changes by G, and G by -stiffness (F - F_rest) - damping G.
    const float stiffness = config->stiffness / config->inertia * sample_time_s * sample_time_s;
    const float damping   = config->damping / config->inertia * sample_time_s;
    if (!within(stiffness, 1.0e-9f, 1.0e4f) || !within(damping, 0.0f, 1.0e4f))
    {
        return TRIBO_ERR_ARM_TOO_FAST;
    }

    const matrix_t change = exponential_minus_one((matrix_t){0.0f, 1.0f, -stiffness, -damping});
    // F_rest = F + d, so the decaying distance from rest is -d.
    params->phi_d   = -change.a11;
    params->phi_g   = change.a12;
    params->gamma_d = -change.a21;
    params->gamma_g = 1.0f + change.a22;
    return TRIBO_OK;
}

void tribo_arm_f32_reset(tribo_arm_f32_state_t *state)
{
    state->force_n        = 0.0f;
    state->force_change_n = 0.0f;
    state->clamped        = 0;
}

float tribo_arm_f32_step(const tribo_arm_f32_params_t *params, tribo_arm_f32_state_t *state, float drive_n)
{
    arm_f32_step(params, state, drive_n);
    return state->force_n;
}
