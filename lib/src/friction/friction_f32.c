#include "tribo/friction_f32.h"

#include "../number/ranges.h"
#include "law_f32.h"

#include <stddef.h>

#define ROW(...) PARAMETERS_ROW(tribo_friction_f32_config_t, __VA_ARGS__)
const tribo_parameter_t tribo_friction_parameters[]  = {TRIBO_FRICTION_PARAMETERS(ROW)};
const tribo_parameter_t tribo_breakaway_parameters[] = {TRIBO_BREAKAWAY_PARAMETERS(ROW)};
const tribo_parameter_t tribo_table_parameters[]     = {TRIBO_TABLE_PARAMETERS(ROW)};
#undef ROW

#define NUMBER(...) PARAMETERS_ELEMENT(tribo_breakaway_point_f32_t, __VA_ARGS__)
static const tribo_parameter_t point_numbers[] = {TRIBO_POINT_ELEMENTS(NUMBER)};
#undef NUMBER

tribo_status_t tribo_friction_f32_refuse_point(tribo_status_t                     status,
                                               const tribo_friction_f32_config_t *config,
                                               uint32_t                           index)
{
    const uint32_t number = (uint32_t)status - (uint32_t)TRIBO_ERR_TABLE_FORCE;
    return tribo_element_refuse(status, point_numbers, number, &config->table[index], index, config->refusal);
}

static tribo_status_t check_table(const tribo_friction_f32_config_t *config)
{
    const uint32_t numbers = sizeof point_numbers / sizeof point_numbers[0];
    if (config->table_length < 1u || config->table_length > TRIBO_BREAKAWAY_POINTS_MAX)
    {
        return TRIBO_ERR_TABLE_LENGTH;
    }
    tribo_status_t status = TRIBO_OK;
    for (uint32_t i = 0; i < config->table_length && status == TRIBO_OK; i++)
    {
        const tribo_breakaway_point_f32_t *const point = &config->table[i];
        const bool                               rises = i == 0u || point->force_n > config->table[i - 1u].force_n;

        status = rises ? tribo_element_check(point_numbers, numbers, point, i, config->refusal)
                       : tribo_friction_f32_refuse_point(TRIBO_ERR_TABLE_FORCE, config, i);
    }
    return status;
}

static tribo_status_t check_breakaway(const tribo_friction_f32_config_t *config)
{
    if (config->table != NULL)
    {
        return check_table(config);
    }
    return config->table_length != 0u ? TRIBO_ERR_TABLE_LENGTH : PARAMETERS_CHECK(tribo_breakaway_parameters, config);
}

tribo_status_t tribo_friction_f32_init(tribo_friction_f32_params_t       *params,
                                       const tribo_friction_f32_config_t *config,
                                       float                              sample_time_s)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    if (!sample_time_ok(sample_time_s))
    {
        return TRIBO_ERR_SAMPLE_TIME;
    }
    const float    pulse_samples = config->pulse_width_s / sample_time_s;
    tribo_status_t status        = PARAMETERS_CHECK(tribo_friction_parameters, config);
    if (status == TRIBO_OK && !(config->k_min <= config->k_max))
    {
        status = TRIBO_ERR_K_MIN;
    }
    status = status != TRIBO_OK ? status : check_breakaway(config);
    if (status == TRIBO_OK && !within(pulse_samples, 0.5f, (float)TRIBO_EDGE_WIDTH_MAX + 0.49f))
    {
        status = TRIBO_ERR_PULSE_WIDTH;
    }
    if (status != TRIBO_OK)
    {
        return status;
    }

    const float e_fold = 2.0f * 1.44269504f * config->m; // e^x = 2^(x/ln 2)
    const float k_min  = 1.57108067f * config->k_min;    // research/fit_friction.py
    const float k_max  = 1.57108067f * config->k_max;

    params->rate_hz           = 1.0f / sample_time_s;
    params->exponent_per_rise = e_fold / config->v0_n_per_s * params->rate_hz;
    params->exponent_at_rest  = e_fold;
    params->k[0].at_0         = 0.125f * k_min;
    params->k[0].per_power    = k_max;
    params->k[1].at_0         = 0.125f * k_max;
    params->k[1].per_power    = k_min;
    params->law[0]            = config->positive;
    params->law[1]            = config->negative;
    params->table             = config->table;
    params->table_length      = (uint8_t)(config->table != NULL ? config->table_length : 0u);
    params->gravity_n         = config->gravity_n + 0.0f; // -0 would make n = -0
    params->pulse_width       = (uint8_t)(pulse_samples + 0.5f);
    params->set_level         = config->set_level;
    params->reset_level       = config->reset_level;
    return TRIBO_OK;
}

tribo_status_t tribo_friction_f32_init_law(tribo_friction_f32_params_t       *params,
                                           const tribo_friction_f32_config_t *config)
{
    if (!within(config->gravity_n, -TRIBO_F32_FORCE_MAX_N, TRIBO_F32_FORCE_MAX_N))
    {
        return TRIBO_ERR_GRAVITY;
    }
    *params = (tribo_friction_f32_params_t){.law       = {config->positive, config->negative},
                                            .gravity_n = config->gravity_n + 0.0f}; // -0 would make n = -0
    return PARAMETERS_CHECK(tribo_breakaway_parameters, config);
}

void tribo_friction_f32_reset(tribo_friction_f32_state_t *state)
{
    state->n_n        = 0.0f;
    state->bad_inputs = 0;
    relay_reset(&state->relay);
}

/// L is linear between the points and constant beyond the first and the last. Visits every point, so the time does not
/// depend on the load.
void tribo_friction_f32_look_up(const tribo_friction_f32_params_t *params, float load_n, float L_n[2])
{
    if (params->table == NULL) // a bit of table_length has flipped: there is no table
    {
        L_n[0] = friction_f32_affine(&params->law[0], load_n);
        L_n[1] = friction_f32_affine(&params->law[1], load_n);
        return;
    }
    const uint32_t length = params->table_length;
    uint32_t       below  = 0; // points at or below the load
    for (uint32_t i = 0; i < length; i++)
    {
        below += load_n >= params->table[i].force_n;
    }
    const tribo_breakaway_point_f32_t *lower = &params->table[below > 0u ? below - 1u : 0u];
    const tribo_breakaway_point_f32_t *upper = &params->table[below < length ? below : length - 1u];

    const float span = upper->force_n - lower->force_n;
    const float part = span > 0.0f ? (load_n - lower->force_n) / span : 0.0f;
    L_n[0]           = lower->positive_n + part * (upper->positive_n - lower->positive_n);
    L_n[1]           = lower->negative_n + part * (upper->negative_n - lower->negative_n);
}

float tribo_friction_f32_step(const tribo_friction_f32_params_t *params,
                              tribo_friction_f32_state_t        *state,
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
    const float n = bad ? state->n_n : u_n - force_n + params->gravity_n;
    return friction_f32_step(params, state, n, bad_force ? 0.0f : force_n, signals);
}

uint8_t tribo_relay_latch_step(tribo_relay_latch_t *latch, uint8_t pulses)
{
    const uint32_t events = TRIBO_RELAY_SET1 | TRIBO_RELAY_SET2 | TRIBO_RELAY_RESET1 | TRIBO_RELAY_RESET2;
    return (uint8_t)relay_latch_step(latch, pulses & events);
}
