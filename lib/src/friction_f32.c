#include "tribo/friction_f32.h"

#include "exact_f32.h"

#include <stddef.h>

tribo_friction_f32_config_t tribo_friction_f32_paper(void)
{
    const tribo_friction_f32_config_t paper = {
        .k_min         = 6.0f,
        .k_max         = 20.0f,
        .m             = 3.0f,
        .v0_n_per_s    = 0.007f,
        .positive      = {.offset_n = 0.007f, .slope = 0.3f},
        .negative      = {.offset_n = 0.007f, .slope = 0.3f},
        .table         = NULL,
        .table_length  = 0,
        .set_level     = 0.75f,
        .reset_level   = 0.8f,
        .pulse_width_s = 0.003f,
        .gravity_n     = 0.0f,
    };
    return paper;
}

static tribo_status_t check_law(const tribo_breakaway_f32_t *law)
{
    if (!within(law->offset_n, 1.0e-6f, TRIBO_F32_FORCE_MAX_N))
    {
        return TRIBO_ERR_BREAKAWAY_OFFSET;
    }
    if (!within(law->slope, 0.0f, 10.0f))
    {
        return TRIBO_ERR_BREAKAWAY_SLOPE;
    }
    return TRIBO_OK;
}

static tribo_status_t check_table(const tribo_breakaway_point_f32_t *table, uint32_t length)
{
    if (length < 1u || length > TRIBO_BREAKAWAY_POINTS_MAX)
    {
        return TRIBO_ERR_TABLE_LENGTH;
    }
    for (uint32_t i = 0; i < length; i++)
    {
        const bool rises = i == 0u || table[i].force_n > table[i - 1u].force_n;
        if (!within(table[i].force_n, 0.0f, TRIBO_F32_FORCE_MAX_N) || !rises)
        {
            return TRIBO_ERR_TABLE_FORCE;
        }
        if (!within(table[i].positive_n, 1.0e-6f, TRIBO_F32_FORCE_MAX_N) ||
            !within(table[i].negative_n, 1.0e-6f, TRIBO_F32_FORCE_MAX_N))
        {
            return TRIBO_ERR_TABLE_BREAKAWAY;
        }
    }
    return TRIBO_OK;
}

static tribo_status_t check_breakaway(const tribo_friction_f32_config_t *config)
{
    if (config->table != NULL)
    {
        return check_table(config->table, config->table_length);
    }
    const tribo_status_t status = check_law(&config->positive);
    return status != TRIBO_OK ? status : check_law(&config->negative);
}

static tribo_status_t check_rate_law(const tribo_friction_f32_config_t *config)
{
    // k_max first: a NaN there would make every k_min look too large.
    if (!within(config->k_max, 1.01f, 1000.0f))
    {
        return TRIBO_ERR_K_MAX;
    }
    if (!within(config->k_min, 1.01f, config->k_max))
    {
        return TRIBO_ERR_K_MIN;
    }
    if (!within(config->m, 0.0f, 100.0f))
    {
        return TRIBO_ERR_M;
    }
    if (!within(config->v0_n_per_s, 1.0e-6f, 1.0e6f))
    {
        return TRIBO_ERR_V0;
    }
    return TRIBO_OK;
}

static tribo_status_t check_relays(const tribo_friction_f32_config_t *config, float pulse_samples)
{
    if (!within(config->set_level, FLT_MIN, 1.0f))
    {
        return TRIBO_ERR_SET_LEVEL;
    }
    if (!within(config->reset_level, FLT_MIN, 1.0f))
    {
        return TRIBO_ERR_RESET_LEVEL;
    }
    if (!within(pulse_samples, 0.5f, (float)TRIBO_EDGE_WIDTH_MAX + 0.49f))
    {
        return TRIBO_ERR_PULSE_WIDTH;
    }
    return TRIBO_OK;
}

tribo_status_t tribo_friction_f32_init(tribo_friction_f32_params_t       *params,
                                       const tribo_friction_f32_config_t *config,
                                       float                              sample_time_s)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    if (!within(sample_time_s, 1.0e-6f, 0.1f))
    {
        return TRIBO_ERR_SAMPLE_TIME;
    }
    const float    pulse_samples = config->pulse_width_s / sample_time_s;
    tribo_status_t status        = check_rate_law(config);
    status                       = status != TRIBO_OK ? status : check_breakaway(config);
    status                       = status != TRIBO_OK ? status : check_relays(config, pulse_samples);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!within(config->gravity_n, -TRIBO_F32_FORCE_MAX_N, TRIBO_F32_FORCE_MAX_N))
    {
        return TRIBO_ERR_GRAVITY;
    }

    params->rate_hz      = 1.0f / sample_time_s;
    params->k_mean       = 0.5f * (config->k_max + config->k_min);
    params->k_half       = 0.5f * (config->k_max - config->k_min);
    params->m            = config->m;
    params->m_over_v0    = config->m / config->v0_n_per_s;
    params->positive     = config->positive;
    params->negative     = config->negative;
    params->table        = config->table;
    params->table_length = (uint8_t)(config->table != NULL ? config->table_length : 0u);
    params->set_level    = config->set_level;
    params->reset_level  = config->reset_level;
    params->gravity_n    = config->gravity_n;
    params->pulse_width  = (uint8_t)(pulse_samples + 0.5f);
    return TRIBO_OK;
}

void tribo_friction_f32_reset(tribo_friction_f32_state_t *state)
{
    state->n_n        = 0.0f;
    state->bad_inputs = 0;
    tribo_relay_reset(&state->relay);
}

/// tanh(x)/x for x^2 = s, a minimax rational over |x| <= 6 (tools/fit_tanh.py).
static inline float tanh_over_x(float s)
{
    const float p = ((4.56887064e-06f * s + 2.40419268e-03f) * s + 1.24412098e-01f) * s + 9.99999697e-01f;
    const float q = ((1.56538452e-04f * s + 2.16554295e-02f) * s + 4.57742878e-01f) * s + 1.0f;
    return p / q;
}

/// tanh(x) within +-1 for every finite x.
static inline float bounded_tanh(float x)
{
    const float          above = x > -6.0f ? x : -6.0f;
    const volatile float t     = above < 6.0f ? above : 6.0f; // volatile: no shortcut for the bounds
    const float          read  = t;
    return read * tanh_over_x(read * read);
}

typedef struct
{
    float positive_n;
    float negative_n;
} breakaway_t;

/// Linear between the points, clamped at both ends. Visits every point, whatever the force.
static breakaway_t look_up(const tribo_breakaway_point_f32_t *table, uint32_t length, float force_n)
{
    uint32_t below = 0; // points at or below the force
    for (uint32_t i = 0; i < length; i++)
    {
        below += force_n >= table[i].force_n;
    }
    const tribo_breakaway_point_f32_t *lower = &table[below > 0u ? below - 1u : 0u];
    const tribo_breakaway_point_f32_t *upper = &table[below < length ? below : length - 1u];

    const float span = upper->force_n - lower->force_n;
    const float part = span > 0.0f ? (force_n - lower->force_n) / span : 0.0f;
    return (breakaway_t){.positive_n = lower->positive_n + part * (upper->positive_n - lower->positive_n),
                         .negative_n = lower->negative_n + part * (upper->negative_n - lower->negative_n)};
}

static inline breakaway_t breakaway(const tribo_friction_f32_params_t *params, float force_n)
{
    const float load_n = magnitude(force_n);
    if (params->table != NULL)
    {
        return look_up(params->table, params->table_length, load_n);
    }
    return (breakaway_t){.positive_n = params->positive.offset_n + params->positive.slope * load_n,
                         .negative_n = params->negative.offset_n + params->negative.slope * load_n};
}

/// Comparators in front of the relays, Fig. 12. Reset looks at n[k-1], so that one large step from above L2 to
/// below it still counts as a crossing while decreasing (Fig. 5).
static inline uint8_t relay_events(const tribo_friction_f32_params_t *params, breakaway_t L, float n, float n_before)
{
    const uint32_t set1   = n < params->set_level * L.positive_n;
    const uint32_t set2   = n > -params->set_level * L.negative_n;
    const uint32_t reset1 = (uint32_t)(n > n_before) & (uint32_t)(n_before < -params->reset_level * L.negative_n);
    const uint32_t reset2 = (uint32_t)(n < n_before) & (uint32_t)(n_before > params->reset_level * L.positive_n);
    return (uint8_t)(set1 * TRIBO_RELAY_SET1 | set2 * TRIBO_RELAY_SET2 | reset1 * TRIBO_RELAY_RESET1 |
                     reset2 * TRIBO_RELAY_RESET2);
}

/// Eq. (3) before the saturation, on the branch of Q = 1.
static inline float hysteresis(const tribo_friction_f32_params_t *params, float n, float L, float v)
{
    const float k = params->k_mean - params->k_half * bounded_tanh(params->m_over_v0 * v - params->m);
    const float x = n / (k * L);
    const float s = x * x;
    return n * tanh_over_x(s < 36.0f ? s : 36.0f);
}

float tribo_friction_f32_step(const tribo_friction_f32_params_t *params,
                              tribo_friction_f32_state_t        *state,
                              float                              u_n,
                              float                              force_n,
                              tribo_friction_f32_signals_t      *signals)
{
    const float n_before  = state->n_n;
    const bool  bad_force = exceeds(force_n, TRIBO_F32_FORCE_MAX_N);
    const bool  bad       = bad_force || exceeds(u_n, TRIBO_F32_FORCE_MAX_N);
    if (bad)
    {
        count(&state->bad_inputs);
    }

    const float       n    = bad ? n_before : u_n - force_n + params->gravity_n;
    const breakaway_t both = breakaway(params, bad_force ? 0.0f : force_n);
    const float       L    = n >= 0.0f ? both.positive_n : both.negative_n;
    const float       rise = magnitude(n) - magnitude(n_before);
    const float       v    = rise * params->rate_hz;
    const uint8_t     relays =
        tribo_relay_step(&state->relay, params->pulse_width, relay_events(params, both, n, n_before));
    const bool q1 = (relays & TRIBO_RELAY_Q1) != 0u;
    const bool q2 = (relays & TRIBO_RELAY_Q2) != 0u;
    const bool q  = v > 0.0f && (n > 0.0f ? q2 : q1); // |n| has risen, so n is not 0

    // Both branches are computed, always: volatile, so that a tick costs the same on either.
    const volatile float curved = hysteresis(params, n, L, v);
    const float          wanted = q ? curved : n;
    const float          above  = wanted > -both.negative_n ? wanted : -both.negative_n;
    const float          f      = above < both.positive_n ? above : both.positive_n;

    state->n_n         = n;
    signals->n_n       = n;
    signals->L_n       = L;
    signals->v_n_per_s = v;
    signals->f_n       = f;
    signals->q1        = q1;
    signals->q2        = q2;
    signals->q         = q;
    return f;
}
