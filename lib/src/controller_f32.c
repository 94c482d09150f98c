#include "tribo/controller_f32.h"

#include "exact_f32.h"

#include <stddef.h>

#define INPUT_MAX_N 4.0e6f // above gain * f^ and r - y of an accepted loop
#define U_MAX_N     1.0e6f
#define DEGREE_MAX  (2u * TRIBO_BIQUAD_SECTIONS_MAX)

/// Coefficients by rising power.
typedef struct
{
    float    c[DEGREE_MAX + 1u];
    uint32_t degree;
} polynomial_t;

/// p times (x^2 + c1 x + c0).
static void multiply_quadratic(polynomial_t *p, float c1, float c0)
{
    p->c[p->degree + 1u] = 0.0f;
    p->c[p->degree + 2u] = 0.0f;
    for (uint32_t i = p->degree + 3u; i-- > 0u;)
    {
        const float once  = i >= 1u ? p->c[i - 1u] : 0.0f;
        const float twice = i >= 2u ? p->c[i - 2u] : 0.0f;
        p->c[i]           = twice + c1 * once + c0 * p->c[i];
    }
    p->degree += 2u;
}

/// Routh's array: true when every root of p lies in the open left half plane.
static bool is_hurwitz(const polynomial_t *p)
{
    float row[2][DEGREE_MAX + 3u] = {{0.0f}}; // the last two rows of the array
    for (uint32_t i = 0; i <= p->degree; i++)
    {
        row[i % 2u][i / 2u] = p->c[p->degree - i];
    }
    const float sign = row[0][0] < 0.0f ? -1.0f : 1.0f;
    for (uint32_t i = 1; i <= p->degree; i++)
    {
        float       *upper = row[(i + 1u) % 2u];
        const float *lower = row[i % 2u];
        if (!within(sign * lower[0], FLT_MIN, FLT_MAX))
        {
            return false;
        }
        const float ratio = upper[0] / lower[0];
        for (uint32_t j = 0; j <= DEGREE_MAX / 2u; j++)
        {
            upper[j] = upper[j + 1u] - ratio * lower[j + 1u];
        }
    }
    return true;
}

/// True when every root of p, in d = z - 1, lies inside the unit circle of z: with d = 2w/(1 - w) that circle is the
/// left half plane of w, and roots near z = 1 keep their relative precision.
static bool is_schur(const polynomial_t *p)
{
    const uint32_t n     = p->degree;
    polynomial_t   q     = {{p->c[n]}, n};
    polynomial_t   power = {{1.0f}, n}; // (1 - w)^(n-k)
    for (uint32_t k = n; k-- > 0u;)
    {
        for (uint32_t i = n; i > 0u; i--)
        {
            power.c[i] -= power.c[i - 1u];
        }
        for (uint32_t i = n; i > 0u; i--)
        {
            q.c[i] = 2.0f * q.c[i - 1u] + p->c[k] * power.c[i];
        }
        q.c[0] = p->c[k] * power.c[0];
    }
    return is_hurwitz(&q);
}

/// The largest c of 1, -1, 1/2, -1/2 ... for which the conditioned cascade is stable, 0 if there is none.
/// Its poles are the roots of (1 - c) A + c B/D, with A and B the cascade's denominator and numerator.
static float conditioning(const tribo_biquad_f32_params_t *cascade)
{
    polynomial_t A = {{1.0f}, 0};
    polynomial_t B = {{1.0f}, 0};
    for (uint32_t i = 0; i < cascade->count; i++)
    {
        const tribo_biquad_f32_section_t *s = &cascade->section[i];
        multiply_quadratic(&A, s->a1, s->a2);
        multiply_quadratic(&B, s->b1 / s->b0, s->b2 / s->b0);
    }
    for (float c = 1.0f; c > 1.0e-6f; c *= 0.5f)
    {
        polynomial_t plus  = A;
        polynomial_t minus = A;
        for (uint32_t i = 0; i <= A.degree; i++)
        {
            plus.c[i]  = (1.0f - c) * A.c[i] + c * B.c[i];
            minus.c[i] = (1.0f + c) * A.c[i] - c * B.c[i];
        }
        if (is_schur(&plus))
        {
            return c;
        }
        if (is_schur(&minus))
        {
            return -c;
        }
    }
    return 0.0f;
}

static tribo_status_t feedthrough(const tribo_biquad_f32_params_t *cascade, float *D)
{
    *D = 1.0f;
    for (uint32_t i = 0; i < cascade->count; i++)
    {
        const float b0 = cascade->section[i].b0;
        if (!within(magnitude(b0), 1.0e-6f, 1.0e6f))
        {
            return TRIBO_ERR_SECTION_FEEDTHROUGH;
        }
        *D *= b0;
    }
    return TRIBO_OK;
}

tribo_status_t tribo_controller_f32_init(tribo_controller_f32_params_t       *params,
                                         const tribo_controller_f32_config_t *config)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_controller_f32_params_t made   = {.u_min_n = config->u_min_n, .u_max_n = config->u_max_n};
    tribo_status_t                status = tribo_biquad_f32_init(&made.cascade, config->sections, config->section_count);
    if (status != TRIBO_OK)
    {
        return status;
    }
    float D = 1.0f;
    status  = feedthrough(&made.cascade, &D);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!within(config->u_min_n, -U_MAX_N, 0.0f))
    {
        return TRIBO_ERR_U_MIN;
    }
    if (!within(config->u_max_n, 0.0f, U_MAX_N) || !(config->u_max_n > config->u_min_n))
    {
        return TRIBO_ERR_U_MAX;
    }
    const float c = conditioning(&made.cascade);
    if (c == 0.0f)
    {
        return TRIBO_ERR_ANTI_WINDUP;
    }
    made.anti_windup = c / D;
    *params          = made;
    return TRIBO_OK;
}

void tribo_controller_f32_reset(tribo_controller_f32_state_t *state)
{
    tribo_biquad_f32_reset(&state->cascade);
    state->bad_inputs    = 0;
    state->limited_ticks = 0;
}

float tribo_controller_f32_step(const tribo_controller_f32_params_t *params,
                                tribo_controller_f32_state_t        *state,
                                float                                e_n,
                                float                                feedforward_n,
                                tribo_controller_f32_signals_t      *signals)
{
    const bool bad_e           = exceeds(e_n, INPUT_MAX_N);
    const bool bad_feedforward = exceeds(feedforward_n, INPUT_MAX_N);
    if (bad_e || bad_feedforward)
    {
        count(&state->bad_inputs);
    }
    const float e = bad_e ? 0.0f : e_n;
    const float v = tribo_biquad_f32_output(&params->cascade, &state->cascade, e);

    const float wanted  = v + (bad_feedforward ? 0.0f : feedforward_n);
    const float above   = wanted > params->u_min_n ? wanted : params->u_min_n;
    const float u       = above < params->u_max_n ? above : params->u_max_n;
    const bool  limited = u != wanted;
    if (limited)
    {
        count(&state->limited_ticks);
    }
    tribo_biquad_f32_advance(&params->cascade, &state->cascade, e, (u - wanted) * params->anti_windup);

    signals->v_n     = v;
    signals->u_n     = u;
    signals->limited = limited;
    return u;
}

void tribo_controller_f32_change(const tribo_controller_f32_params_t *from,
                                 const tribo_controller_f32_params_t *to,
                                 tribo_controller_f32_state_t        *state,
                                 float                                e_n,
                                 float                                offset_n)
{
    tribo_biquad_f32_change(&from->cascade,
                            &to->cascade,
                            &state->cascade,
                            exceeds(e_n, INPUT_MAX_N) ? 0.0f : e_n,
                            exceeds(offset_n, INPUT_MAX_N) ? 0.0f : offset_n);
}
