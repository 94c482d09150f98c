#include "tribo/lugre_f32.h"

#include "ieee_f32.h"

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
        .positive  = {.offset_n = 0.007f, .slope = 0.3f},
        .negative  = {.offset_n = 0.007f, .slope = 0.3f},
        .gravity_n = 0.0f,
    };
    return paper;
}

static tribo_status_t check_law(const tribo_breakaway_f32_t *law)
{
    if (!within(law->offset_n, 1.0e-6f, TRIBO_F32_FORCE_MAX_N))
    {
        return TRIBO_ERR_BREAKAWAY_OFFSET;
    }
    return within(law->slope, 0.0f, 10.0f) ? TRIBO_OK : TRIBO_ERR_BREAKAWAY_SLOPE;
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
    status = status != TRIBO_OK ? status : check_law(&config->positive);
    status = status != TRIBO_OK ? status : check_law(&config->negative);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!within(config->gravity_n, -TRIBO_F32_FORCE_MAX_N, TRIBO_F32_FORCE_MAX_N))
    {
        return TRIBO_ERR_GRAVITY;
    }
    params->a         = (1.0f + beta) * c;
    params->b_and_1   = 1.0f + b;
    params->beta      = beta;
    params->c         = c;
    params->stuck     = c / (params->b_and_1 + params->a);
    params->gamma_g   = matrices.gamma_g;
    params->law[0]    = config->positive;
    params->law[1]    = config->negative;
    params->gravity_n = config->gravity_n;
    return TRIBO_OK;
}

void tribo_lugre_f32_reset(tribo_lugre_f32_state_t *state)
{
    state->n_n        = 0.0f;
    state->bristle_n  = 0.0f;
    state->drive_n    = 0.0f;
    state->bad_inputs = 0;
}

static float affine(const tribo_breakaway_f32_t *law, float load_n)
{
    return law->offset_n + law->slope * load_n;
}

float tribo_lugre_f32_step(const tribo_lugre_f32_params_t *params,
                           tribo_lugre_f32_state_t        *state,
                           float                           u_n,
                           float                           force_n,
                           tribo_lugre_f32_signals_t      *signals)
{
    const bool bad_force = exceeds(force_n, TRIBO_F32_FORCE_MAX_N);
    float      n         = u_n - force_n + params->gravity_n;
    if (bad_force || exceeds(u_n, TRIBO_F32_FORCE_MAX_N))
    {
        count(&state->bad_inputs);
        n = state->n_n;
    }
    const float load     = bad_force ? 0.0f : magnitude(force_n);
    const float positive = affine(&params->law[0], load);
    const float negative = affine(&params->law[1], load);

    // The linear equation for f, with the D of an arm that sticks.
    const float carried = n + params->gamma_g * state->drive_n; // n'
    const float stretch = carried - state->bristle_n;
    const float L_stuck = stretch >= 0.0f ? positive : negative;
    const float inverse = L_stuck / (L_stuck + params->stuck * magnitude(stretch));            // 1/D*
    const float pull    = ((1.0f + params->beta) * inverse - params->beta) * state->bristle_n; // P
    float       r       = (carried - pull) / (params->b_and_1 + params->a * inverse);
    float       f       = carried - r;
    if (f > positive)
    {
        f = positive;
        r = carried - f;
    }
    else if (f < -negative)
    {
        f = -negative;
        r = carried - f;
    }

    // The bristles with the motion that this f leaves; L is that of its direction.
    const float L    = r >= 0.0f ? positive : negative;
    const float path = params->c * r;
    state->bristle_n = (state->bristle_n + path) * (L / (L + magnitude(path)));
    state->drive_n   = r;
    state->n_n       = n;

    signals->n_n       = n;
    signals->L_n       = f >= 0.0f ? positive : negative;
    signals->bristle_n = state->bristle_n;
    signals->f_n       = f;
    return f;
}
