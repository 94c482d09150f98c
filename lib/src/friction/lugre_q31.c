#include "lugre_q31.h"

#include "tribo/friction_f32.h"
#include "tribo/friction_q31.h"

#include "../number/first_order_q31.h"
#include "../number/fixed_q31.h"
#include "lugre_f32.h"

#include <stddef.h>

/// The most bits, up to `bits_max`, for which x 2^bits is below 2^31.
static int32_t bits_for(float x, int32_t bits_max)
{
    int32_t bits = bits_max;
    while (!(scaled(x, bits) < 2147483648.0f))
    {
        bits--;
    }
    return bits;
}

tribo_status_t tribo_lugre_q31_init(tribo_lugre_q31_params_t       *params,
                                    const tribo_lugre_f32_config_t *config,
                                    const tribo_arm_f32_config_t   *arm,
                                    float                           sample_time_s)
{
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_lugre_f32_params_t f32;
    const tribo_status_t     status = tribo_lugre_f32_init(&f32, config, arm, sample_time_s);
    if (status != TRIBO_OK)
    {
        return status;
    }
    const int32_t divisor_bits = bits_for(f32.a + f32.b_and_1, 30);
    const int32_t c_bits       = bits_for(f32.c, 50);
    if (divisor_bits < 10)
    {
        return TRIBO_ERR_BRISTLE_DAMPING;
    }
    params->a       = fixed_unsigned(f32.a, divisor_bits);
    params->b_and_1 = fixed_unsigned(f32.b_and_1, divisor_bits);
    params->one     = UINT32_C(1) << divisor_bits;
    params->beta    = fixed(f32.beta, 20);
    params->c       = fixed_unsigned(f32.c, c_bits);
    params->c_shift = (uint8_t)c_bits;
    params->stuck   = fixed_unsigned(f32.stuck, 32);
    params->gamma_g = fixed(f32.gamma_g, 28);
    return TRIBO_OK;
}

void tribo_lugre_q31_reset(tribo_lugre_q31_state_t *state)
{
    state->bristle   = 0;
    state->saturated = 0;
    state->drive     = 0;
}

int32_t tribo_lugre_q31_step(const tribo_lugre_q31_params_t    *params,
                             const tribo_friction_q31_params_t *friction,
                             tribo_lugre_q31_state_t           *state,
                             int32_t                            u,
                             int32_t                            force,
                             tribo_friction_q31_signals_t      *signals)
{
    const int32_t n = tribo_q31_saturate((int64_t)u - force + friction->gravity, &state->saturated);
    return lugre_q31_step(params, friction, state, n, force, signals);
}

int32_t tribo_lugre_q31_model_step(const tribo_friction_model_q31_t       *model,
                                   const tribo_friction_q31_params_t      *friction,
                                   tribo_compensator_friction_q31_state_t *state,
                                   int32_t                                 n,
                                   int32_t                                 force,
                                   tribo_friction_q31_signals_t           *signals)
{
    return lugre_q31_step((const tribo_lugre_q31_params_t *)model, friction, &state->lugre, n, force, signals);
}

// The bristles start so that they hold the arm.
int32_t tribo_lugre_q31_model_enter(const tribo_friction_model_q31_t       *model,
                                    const tribo_friction_q31_params_t      *friction,
                                    tribo_compensator_friction_q31_state_t *state,
                                    int32_t                                 n,
                                    int32_t                                 force)
{
    (void)model;
    int32_t L[2];
    lugre_q31_breakaway(friction, force, L);
    tribo_lugre_q31_reset(&state->lugre);
    state->lugre.bristle = limit_q31(n, -L[1], L[0]);
    return state->lugre.bristle;
}

void tribo_lugre_q31_attach(tribo_compensator_q31_params_t *compensator, tribo_lugre_q31_params_t *lugre)
{
    lugre->model.step  = tribo_lugre_q31_model_step;
    lugre->model.enter = tribo_lugre_q31_model_enter;
    compensator->model = &lugre->model;
}
