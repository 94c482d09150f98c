#include "tribo/controller_f32.h"

#include "../number/ranges.h"
#include "anti_windup_f32.h"

#include <stddef.h>

#define ROW(...) PARAMETERS_ROW(tribo_controller_f32_config_t, __VA_ARGS__)
const tribo_parameter_t tribo_limit_parameters[]   = {TRIBO_LIMIT_PARAMETERS(ROW)};
const tribo_parameter_t tribo_cascade_parameters[] = {TRIBO_CASCADE_PARAMETERS(ROW)};
#undef ROW

#define STATES_MAX (2u * TRIBO_BIQUAD_SECTIONS_MAX)
#define AT_1       1.0e-8f // least distance of a zero from z = 1
#define ON_CIRCLE  4.0e-6f // twice the least distance from the rest of the unit circle: float leaves up to 1e-6

/// A square matrix of a cascade's states w1, w2, w1, w2 ...
typedef struct
{
    float    at[STATES_MAX][STATES_MAX];
    uint32_t size;
} matrix_t;

/// The matrix of the states' change in one tick while u is held at its limit. The cascade's own code computes each
/// column from a unit state.
static matrix_t conditioned_change(const tribo_biquad_f32_params_t *cascade, float anti_windup)
{
    matrix_t change = {.size = 2u * cascade->count};
    for (uint32_t column = 0; column < change.size; column++)
    {
        tribo_biquad_f32_state_t state;
        tribo_biquad_f32_reset(&state);
        float *const unit = column % 2u == 0u ? &state.section[column / 2u].w1 : &state.section[column / 2u].w2;
        *unit             = 1.0f;
        tribo_biquad_f32_outputs_t outputs;
        const float                v = biquad_f32_output(cascade, &state, 0.0f, &outputs);
        biquad_f32_advance(cascade, &state, 0.0f, &outputs, -v * anti_windup);
        *unit -= 1.0f;
        for (uint32_t i = 0; i < cascade->count; i++)
        {
            change.at[2u * i][column]      = state.section[i].w1;
            change.at[2u * i + 1u][column] = state.section[i].w2 + state.section[i].w2_carry;
        }
    }
    return change;
}

/// (1 + E)^2 - 1. Computing the difference from 1 keeps the distance of a slow pole from 1.
static matrix_t twice(const matrix_t *E)
{
    matrix_t result = {.size = E->size};
    for (uint32_t i = 0; i < E->size; i++)
    {
        for (uint32_t j = 0; j < E->size; j++)
        {
            float sum = 2.0f * E->at[i][j];
            for (uint32_t k = 0; k < E->size; k++)
            {
                sum += E->at[i][k] * E->at[k][j];
            }
            result.at[i][j] = sum;
        }
    }
    return result;
}

/// The largest magnitude of the elements of 1 + E. Not finite if any element is not.
static float largest(const matrix_t *E)
{
    float max = 0.0f;
    for (uint32_t i = 0; i < E->size; i++)
    {
        for (uint32_t j = 0; j < E->size; j++)
        {
            const float element = magnitude((i == j ? 1.0f : 0.0f) + E->at[i][j]);
            max                 = element <= max ? max : element;
        }
    }
    return max;
}

/// True if the states decay within 2^24 ticks while u is held at its limit.
static bool dies_away(const tribo_controller_f32_config_t *config,
                      const tribo_biquad_f32_params_t     *cascade,
                      float                                anti_windup)
{
    matrix_t E = conditioned_change(cascade, anti_windup);
    for (uint32_t doubling = 0; doubling < 24u; doubling++)
    {
        controller_f32_pause(config);
        E               = twice(&E);
        const float max = largest(&E);
        if (!(max < 1.0e12f))
        {
            return false;
        }
        if (max < 0.01f)
        {
            return true;
        }
    }
    return false;
}

/// True if the zeros are inside the unit circle by more than rounding can move them. With zeros on or next to the
/// circle, e.g. those of a notch, the last bit of a coefficient would decide, and states with such poles ring for
/// minutes. Slow real zeros are well inside.
static bool zeros_inside(const tribo_biquad_f32_params_t *cascade)
{
    bool inside = true;
    for (uint32_t i = 0; i < cascade->count; i++)
    {
        const tribo_biquad_f32_section_t *s     = &cascade->section[i];
        const float                       c1    = s->b1 / s->b0;
        const float                       c2    = s->b2 / s->b0;
        const bool                        rings = c1 * c1 < 2.0f * c2; // damped by less than 0.7
        inside =
            inside && c2 > AT_1 * c1 && c1 - c2 > (rings ? ON_CIRCLE : 0.0f) && (4.0f - 2.0f * c1) + c2 > ON_CIRCLE;
    }
    return inside;
}

/// True if the cascade is stable when conditioned by `c`. With c = 1 the poles of the conditioned cascade are its
/// zeros.
static bool is_conditioned(const tribo_controller_f32_config_t *config,
                           const tribo_biquad_f32_params_t     *cascade,
                           float                                c,
                           float                                D)
{
    return c == 1.0f ? zeros_inside(cascade) : dies_away(config, cascade, c / D);
}

/// c of the anti-windup: `first` if it is not 0 and the conditioned cascade is stable with it. Otherwise the first of
/// 1, -1, 1/2, -1/2 ... with which it is stable, 0 if there is none.
static float conditioning(const tribo_controller_f32_config_t *config,
                          const tribo_biquad_f32_params_t     *cascade,
                          float                                first,
                          float                                D)
{
    if (first != 0.0f && is_conditioned(config, cascade, first, D))
    {
        return first;
    }
    for (float c = 1.0f; c > 1.0e-6f; c *= 0.5f)
    {
        if (is_conditioned(config, cascade, c, D))
        {
            return c;
        }
        if (is_conditioned(config, cascade, -c, D))
        {
            return -c;
        }
    }
    return 0.0f;
}

static tribo_status_t refuse_b0(tribo_status_t status, const tribo_controller_f32_config_t *config, uint32_t index)
{
    return tribo_element_refuse(status, tribo_section_numbers, 0, &config->sections[index], index, config->refusal);
}

static tribo_status_t feedthrough(const tribo_controller_f32_config_t *config, float *D)
{
    *D = 1.0f;
    for (uint32_t i = 0; i < config->section_count; i++)
    {
        const float b0 = config->sections[i].b0;
        if (!within(magnitude(b0), 1.0e-6f, 1.0e6f))
        {
            return refuse_b0(TRIBO_ERR_SECTION_FEEDTHROUGH, config, i);
        }
        *D *= b0;
    }
    return TRIBO_OK;
}

tribo_status_t tribo_controller_f32_init(tribo_controller_f32_params_t       *params,
                                         const tribo_controller_f32_config_t *config)
{
    float c = 0.0f;
    return tribo_controller_f32_prepare(params, config, &c);
}

tribo_status_t tribo_controller_f32_prepare(tribo_controller_f32_params_t       *params,
                                            const tribo_controller_f32_config_t *config,
                                            float                               *conditioned_by)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_controller_f32_params_t made = {.u_min_n = config->u_min_n, .u_max_n = config->u_max_n};
    tribo_status_t                status =
        tribo_biquad_f32_init(&made.cascade, config->sections, config->section_count, config->refusal);
    if (status != TRIBO_OK)
    {
        return status;
    }
    float D = 1.0f;
    status  = feedthrough(config, &D);
    if (status != TRIBO_OK)
    {
        return status;
    }
    status = PARAMETERS_CHECK(tribo_limit_parameters, config);
    if (status == TRIBO_OK && !(config->u_max_n > config->u_min_n))
    {
        status = TRIBO_ERR_U_MAX;
    }
    if (status != TRIBO_OK)
    {
        return status;
    }
    const float c = conditioning(config, &made.cascade, *conditioned_by, D);
    if (c == 0.0f)
    {
        return refuse_b0(TRIBO_ERR_ANTI_WINDUP, config, 0);
    }
    made.anti_windup = c / D;
    *conditioned_by  = c;
    *params          = made;
    return TRIBO_OK;
}

tribo_status_t tribo_controller_f32_init_pi(tribo_controller_f32_params_t       *params,
                                            const tribo_controller_f32_config_t *config)
{
    *params = (tribo_controller_f32_params_t){.anti_windup = 1.0f / config->sections[0].b0,
                                              .u_min_n     = config->u_min_n,
                                              .u_max_n     = config->u_max_n};
    tribo_biquad_f32_fill(&params->cascade, config->sections, 1);
    return zeros_inside(&params->cascade) ? TRIBO_OK : TRIBO_ERR_ANTI_WINDUP;
}

void tribo_controller_f32_reset(tribo_controller_f32_state_t *state)
{
    tribo_biquad_f32_reset(&state->cascade);
    state->limited_ticks = 0;
}
