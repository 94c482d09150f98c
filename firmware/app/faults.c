#include "app/faults.h"

static uint32_t ticks_of(uint32_t ms, uint32_t period_us)
{
    return (ms * 1000u + period_us - 1u) / period_us;
}

static int32_t thousandths_of(float x)
{
    return (int32_t)(x * 1000.0f + 0.5f);
}

/// The smallest nonzero for less than that: 0 means off.
static loop_force_t force_of(float x, float full)
{
    const loop_force_t force = scaling_number(x, full);
    return x > 0.0f && force == 0 ? tribo_force_of_word(1u) : force;
}

/// At least 1: 0 means off.
static int32_t travel_of(float units)
{
    return units >= 2147483647.0f ? INT32_MAX : units > 0.0f && units < 1.0f ? 1 : (int32_t)units;
}

void faults_init(faults_bounds_t *bounds, const drive_config_t *config)
{
    const float period_s = (float)config->period_us * 1e-6f;

    *bounds = (faults_bounds_t){
        .residual            = scaling_number(config->residual_n, config->full_scale_n),
        .residual_slope      = scaling_gain(config->residual_slope),
        .tracking            = scaling_number(config->tracking_n, config->full_scale_n),
        .tare_max            = scaling_number(config->tare_max_n, config->full_scale_n),
        .residual_ticks      = config->residual_n > 0.0f ? ticks_of(config->residual_ms, config->period_us) : 0u,
        .tracking_ticks      = config->tracking_n > 0.0f ? ticks_of(config->tracking_ms, config->period_us) : 0u,
        .speed_ticks         = ticks_of(config->speed_ms, config->period_us),
        .travel              = travel_of(config->speed_max_units_per_s * 1e-3f * (float)config->speed_ms),
        .debounce_n          = config->debounce_n,
        .debounce_mask       = UINT32_MAX >> (32u - config->debounce_m),
        .command_limit_ticks = ticks_of(config->command_limit_ms, config->period_us),
        .reference_ticks     = ticks_of(config->reference_ms, config->period_us),
        .ready_ticks         = ticks_of(config->ready_ms, config->period_us),
        .ramp                = force_of(config->reference_ramp_n_per_s * period_s, config->full_scale_n),
        .safe_reference      = scaling_number(config->safe_reference_n, config->full_scale_n),
        .over_current_ma     = thousandths_of(config->over_current_a),
        .bus_low_mv          = thousandths_of(config->bus_low_v),
        .bus_high_mv         = thousandths_of(config->bus_high_v),
        .temperature_max_mc  = thousandths_of(config->temperature_max_c),
        .over_current_ticks  = ticks_of(config->over_current_ms, config->period_us),
        .bus_voltage_ticks   = ticks_of(config->bus_voltage_ms, config->period_us),
        .temperature_ticks   = ticks_of(config->temperature_ms, config->period_us)};
    bounds->is_measured = bounds->over_current_ma > 0 || bounds->bus_low_mv > 0 || bounds->bus_high_mv > 0 ||
                          bounds->temperature_max_mc > 0 || bounds->travel > 0;
}
