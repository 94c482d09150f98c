#include "app/faults.h"

static uint32_t ticks_of(uint32_t ms, uint32_t period_us)
{
    return (ms * 1000u + period_us - 1u) / period_us;
}

static int32_t thousandths_of(float x)
{
    return (int32_t)(x * 1000.0f + 0.5f);
}

/// A positive x never becomes 0, because 0 means off.
static loop_force_t force_of(float x, float full)
{
    const loop_force_t force = scaling_number(x, full);
    return x > 0.0f && force == 0 ? tribo_force_of_word(1u) : force;
}

/// Positive units become at least 1, because 0 means off.
static int32_t travel_of(float units)
{
    return units >= 2147483647.0f ? INT32_MAX : units > 0.0f && units < 1.0f ? 1 : (int32_t)units;
}

/// How swings of a signal fill a level: a swing counts from the part `least` of the range of u on, and a swing over the
/// whole range adds as much as `ms` of time take away.
static faults_swings_t swings_of(float range, float least, float ms, const drive_config_t *config)
{
    const float steps = FAULTS_SWING_STEPS * ms * 1000.0f / (float)config->period_us;
    const float gain  = steps / range * TRIBO_EITHER(1.0f, 4294967296.0f);
    const float most  = TRIBO_EITHER(1e30f, 4e9f);
    return (faults_swings_t){.least = (scaling_rise_t)(least * range),
                             .gain  = (scaling_rise_t)(gain < most ? gain : most)};
}

/// In a second a level loses 500 ms. It therefore tolerates swings of y that add up to half the range of u a second, and
/// swings of u that add up to 1.25 ranges. Noise moves u more than y, so the smallest swing of u that counts is larger. The
/// values come from tests/firmware/loop_study.c.
static void init_swings(faults_bounds_t *bounds, const drive_config_t *config, const loop_params_t *params)
{
    const float range   = (float)scaling_rise(params->controller.TRIBO_N(u_min), params->controller.TRIBO_N(u_max));
    const float h_s     = 1e-6f * (float)config->period_us;
    bounds->swings_of_u = swings_of(range, 3.0f / 16.0f, 400.0f, config);
    bounds->swings_of_y = swings_of(range, 1.0f / 16.0f, 1000.0f, config);
    bounds->moves_of_r  = swings_of(range, 1.0f / 100.0f, 2000.0f, config);
    bounds->follow      = scaling_gain(h_s / (0.05f + h_s));
    bounds->swing_level = FAULTS_SWING_STEPS * (int32_t)ticks_of(config->swing_ms, config->period_us);
    bounds->credit_max  = (int32_t)ticks_of(4000u, config->period_us); // r's credit expires after 4 s
}

void faults_init(faults_bounds_t *bounds, const drive_config_t *config, const loop_params_t *params)
{
    const float period_s = (float)config->period_us * 1e-6f;

    *bounds = (faults_bounds_t){
        .residual       = scaling_number(config->residual_n, config->full_scale_n),
        .residual_slope = scaling_gain(config->residual_slope),
        .tracking       = scaling_number(config->tracking_n, config->full_scale_n),
        .tare_max       = scaling_number(config->tare_max_n, config->full_scale_n),
        .residual_level =
            config->residual_n > 0.0f ? FAULTS_RISE_RESIDUAL * ticks_of(config->residual_ms, config->period_us) : 0u,
        .tracking_level =
            config->tracking_n > 0.0f ? FAULTS_RISE_LOOP * ticks_of(config->tracking_ms, config->period_us) : 0u,
        .speed_ticks         = ticks_of(config->speed_ms, config->period_us),
        .travel              = travel_of(config->speed_max_units_per_s * 1e-3f * (float)config->speed_ms),
        .debounce_n          = config->debounce_n,
        .debounce_mask       = UINT32_MAX >> (32u - config->debounce_m),
        .command_limit_level = FAULTS_RISE_LOOP * ticks_of(config->command_limit_ms, config->period_us),
        .reference_ticks     = ticks_of(config->reference_ms, config->period_us),
        .rest_ticks          = ticks_of(FAULTS_REST_MS, config->period_us),
        .ready_ticks         = ticks_of(config->ready_ms, config->period_us),
        .ramp                = force_of(config->reference_ramp_n_per_s * period_s, config->full_scale_n),
        .safe_reference      = scaling_number(config->safe_reference_n, config->full_scale_n),
        .over_current_ma     = thousandths_of(config->over_current_a),
        .bus_low_mv          = thousandths_of(config->bus_low_v),
        .bus_high_mv         = thousandths_of(config->bus_high_v),
        .temperature_max_mc  = thousandths_of(config->temperature_max_c),
        .over_current_level  = FAULTS_RISE_MEASURED * ticks_of(config->over_current_ms, config->period_us),
        .bus_voltage_level   = FAULTS_RISE_MEASURED * ticks_of(config->bus_voltage_ms, config->period_us),
        .temperature_level   = FAULTS_RISE_MEASURED * ticks_of(config->temperature_ms, config->period_us)};
    bounds->is_measured = bounds->over_current_ma > 0 || bounds->bus_low_mv > 0 || bounds->bus_high_mv > 0 ||
                          bounds->temperature_max_mc > 0 || bounds->travel > 0;
    init_swings(bounds, config, params);
}
