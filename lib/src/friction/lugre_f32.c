#include "lugre_f32.h"

#include "tribo/friction_f32.h"

#include "../number/ieee_f32.h"
#include "../number/ranges.h"
#include "arm_f32.h"

#include <stddef.h>

#define ROW(...) PARAMETERS_ROW(tribo_lugre_f32_config_t, __VA_ARGS__)
const tribo_parameter_t tribo_lugre_parameters[] = {TRIBO_LUGRE_PARAMETERS(ROW)};
#undef ROW

#define C_MIN    1.0e-6f
#define C_MAX    1.0e6f
#define BETA_MAX 1000.0f
#define B_MAX    1000.0f

static tribo_status_t check_bristles(float c, float beta, float b)
{
    if (!within(c, C_MIN, C_MAX))
    {
        return TRIBO_ERR_BRISTLE_STIFFNESS;
    }
    if (!(beta <= BETA_MAX))
    {
        return TRIBO_ERR_BRISTLE_DAMPING;
    }
    return b <= B_MAX ? TRIBO_OK : TRIBO_ERR_BRISTLE_VISCOUS;
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
    status                        = status != TRIBO_OK ? status : PARAMETERS_CHECK(tribo_lugre_parameters, config);
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

float tribo_lugre_f32_model_step(const tribo_friction_model_f32_t       *model,
                                 const tribo_friction_f32_params_t      *friction,
                                 tribo_compensator_friction_f32_state_t *state,
                                 float                                   n_n,
                                 float                                   force_n,
                                 tribo_friction_f32_signals_t           *signals)
{
    const tribo_lugre_f32_params_t *const params = (const tribo_lugre_f32_params_t *)model;
    if (exceeds(force_n, TRIBO_F32_FORCE_MAX_N)) // the arm is corrupt and restarts in this tick
    {
        return lugre_f32_step(params, friction, &state->lugre, state->lugre.n_n, 0.0f, signals);
    }
    return lugre_f32_step(params, friction, &state->lugre, n_n, force_n, signals);
}

// The bristles start so that they hold the arm.
float tribo_lugre_f32_model_enter(const tribo_friction_model_f32_t       *model,
                                  const tribo_friction_f32_params_t      *friction,
                                  tribo_compensator_friction_f32_state_t *state,
                                  float                                   n_n,
                                  float                                   force_n)
{
    (void)model;
    float L[2];
    lugre_f32_breakaway(friction, force_n, L);
    tribo_lugre_f32_reset(&state->lugre);
    state->lugre.bristle_n = limit_f32(n_n, -L[1], L[0]);
    return state->lugre.bristle_n;
}

void tribo_lugre_f32_attach(tribo_compensator_f32_params_t *compensator, tribo_lugre_f32_params_t *lugre)
{
    lugre->model.step  = tribo_lugre_f32_model_step;
    lugre->model.enter = tribo_lugre_f32_model_enter;
    compensator->model = &lugre->model;
}
