#include "tribo/lugre_f32.h"

#include "lugre_f32_step.h"

#include <stddef.h>

#define C_MIN    1.0e-6f
#define C_MAX    1.0e6f
#define BETA_MAX 1000.0f
#define B_MAX    1000.0f

tribo_lugre_f32_config_t tribo_lugre_f32_paper(void)
{
    const tribo_lugre_f32_config_t paper = {
        .stiffness = 1.0e5f,
        .damping   = 316.227766f, // 10^2.5
        .viscous   = 0.4f,
    };
    return paper;
}

static tribo_status_t check_bristles(float c, float beta, float b)
{
    if (!within(c, C_MIN, C_MAX))
    {
        return TRIBO_ERR_BRISTLE_STIFFNESS;
    }
    if (!within(beta, 0.0f, BETA_MAX))
    {
        return TRIBO_ERR_BRISTLE_DAMPING;
    }
    return within(b, 0.0f, B_MAX) ? TRIBO_OK : TRIBO_ERR_BRISTLE_VISCOUS;
}

tribo_status_t tribo_lugre_f32_init(tribo_lugre_f32_params_t       *params,
                                    const tribo_lugre_f32_config_t *config,
                                    const tribo_arm_f32_config_t   *arm,
                                    float                           sample_time_s)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_arm_f32_params_t matrices;
    tribo_status_t         status = tribo_arm_f32_init(&matrices, arm, sample_time_s);
    if (status != TRIBO_OK)
    {
        return status;
    }
    const float per_stiffness = matrices.gamma_d / arm->stiffness; // G/K = h w
    const float c             = config->stiffness * per_stiffness;
    const float beta          = config->damping / (config->stiffness * sample_time_s);
    const float b             = config->viscous * per_stiffness / sample_time_s;

    status = check_bristles(c, beta, b);
    if (status == TRIBO_OK)
    {
        params->a       = (1.0f + beta) * c;
        params->b_and_1 = 1.0f + b;
        params->beta    = beta;
        params->c       = c;
        params->stuck   = c / (params->b_and_1 + params->a);
        params->gamma_g = matrices.gamma_g;
    }
    return status;
}

void tribo_lugre_f32_reset(tribo_lugre_f32_state_t *state)
{
    state->n_n        = 0.0f;
    state->bad_inputs = 0;
    state->bristle_n  = 0.0f;
    state->drive_n    = 0.0f;
}

float tribo_lugre_f32_step(const tribo_lugre_f32_params_t    *params,
                           const tribo_friction_f32_params_t *friction,
                           tribo_lugre_f32_state_t           *state,
                           float                              u_n,
                           float                              force_n,
                           tribo_friction_f32_signals_t      *signals)
{
    const bool bad_force = exceeds(force_n, TRIBO_F32_FORCE_MAX_N);
    const bool bad       = bad_force || exceeds(u_n, TRIBO_F32_FORCE_MAX_N);
    if (bad)
    {
        count(&state->bad_inputs);
    }
    const float n = bad ? state->n_n : u_n - force_n + friction->gravity_n;
    return lugre_f32_step(params, friction, state, n, bad_force ? 0.0f : force_n, signals);
}
