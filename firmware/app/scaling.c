#include "app/scaling.h"

#include <stddef.h>

// --- numbers -------------------------------------------------------------------------------------------------------

#ifdef TRIBO_ARITHMETIC_Q31

#define GAIN_MIN (1.0f / 65536.0f) // a gain this small still has a mantissa of 15 bits
#define GAIN_MAX 1048576.0f

loop_force_t scaling_number(float x, float full)
{
    if (!(x > -full &&
          x < full)) // full scale becomes the number next to the limit, because the loop accepts no force at a limit
    {
        return x == full ? INT32_MAX - 1 : x == -full ? 1 - INT32_MAX : x > full ? INT32_MAX : INT32_MIN;
    }
    return (int32_t)(x / full * 2147483648.0f);
}

float scaling_value(loop_force_t x, float full)
{
    return (float)x * (full / 2147483648.0f);
}

scaling_gain_t scaling_gain(float x)
{
    scaling_gain_t gain     = {.shift = 31};
    float          mantissa = x * 2147483648.0f;
    while (mantissa >= 2147483648.0f)
    {
        mantissa /= 2.0f;
        gain.shift--;
    }
    gain.mantissa = (int32_t)mantissa;
    return gain;
}

static scaling_gain_t reversed(scaling_gain_t gain)
{
    return (scaling_gain_t){.mantissa = -gain.mantissa, .shift = gain.shift};
}

/// Returns the force of the sensor's full range of units as a fraction of the full scale.
static float sensor_gain(const drive_config_t *config, const port_t *port)
{
    return config->sensor_n_per_unit * (port->sensor.full_units / config->full_scale_n);
}

static float command_gain(const drive_config_t *config, const port_t *port)
{
    return config->full_scale_n / (port->output.full_units * config->command_n_per_unit);
}

#else

#define GAIN_MIN 1e-12f
#define GAIN_MAX 1e12f

loop_force_t scaling_number(float x, float full)
{
    (void)full;
    return x;
}

float scaling_value(loop_force_t x, float full)
{
    (void)full;
    return x;
}

scaling_gain_t scaling_gain(float x)
{
    return x;
}

static scaling_gain_t reversed(scaling_gain_t gain)
{
    return -gain;
}

static float sensor_gain(const drive_config_t *config, const port_t *port)
{
    (void)port;
    return config->sensor_n_per_unit;
}

static float command_gain(const drive_config_t *config, const port_t *port)
{
    (void)port;
    return 1.0f / config->command_n_per_unit;
}

#endif

// --- set-up --------------------------------------------------------------------------------------------------------

static bool is_within(float value, float low, float high)
{
    return value >= low && value <= high;
}

static bool refuse(drive_config_error_t *error, unsigned field, float value, float low, float high)
{
    *error = (drive_config_error_t){.field = field, .value = value, .low = low, .high = high};
    return false;
}

static bool is_limited(const port_range_t *range)
{
    return range->high_units > range->low_units;
}

static bool is_in_range(float zero_units, const port_range_t *range)
{
    return !is_limited(range) || is_within(zero_units, range->low_units, range->high_units);
}

static bool refuse_zero(drive_config_error_t *error, unsigned field, float value, const port_range_t *range)
{
    return refuse(error, field, value, range->low_units, range->high_units);
}

/// Returns the output at no current, or the middle of the output's range if the config's value is not usable.
static float no_current_units(const drive_config_t *config, const port_range_t *range)
{
    const float zero = config->command_zero_units;
    const bool  used = is_within(zero, -1e6f, 1e6f) && is_in_range(zero, range);
    return used ? zero : range->low_units + (range->high_units - range->low_units) / 2.0f;
}

bool scaling_init(scaling_t *scaling, const drive_config_t *config, const port_t *port, drive_config_error_t *error)
{
    scaling->no_current = scaling_number(no_current_units(config, &port->output), port->output.full_units);
    if (!drive_config_check(config, error))
    {
        return false;
    }
    const float sensor  = sensor_gain(config, port);
    const float command = command_gain(config, port);
    if (!is_within(sensor, GAIN_MIN, GAIN_MAX))
    {
        const float unit = config->sensor_n_per_unit / sensor;
        return refuse(error,
                      DRIVE_CONFIG_sensor_n_per_unit,
                      config->sensor_n_per_unit,
                      GAIN_MIN * unit,
                      GAIN_MAX * unit);
    }
    if (!is_within(command, GAIN_MIN, GAIN_MAX))
    {
        const float unit = config->command_n_per_unit * command;
        return refuse(error,
                      DRIVE_CONFIG_command_n_per_unit,
                      config->command_n_per_unit,
                      unit / GAIN_MAX,
                      unit / GAIN_MIN);
    }
    if (!is_in_range(config->sensor_zero_units, &port->sensor))
    {
        return refuse_zero(error, DRIVE_CONFIG_sensor_zero_units, config->sensor_zero_units, &port->sensor);
    }
    if (!is_in_range(config->command_zero_units, &port->output))
    {
        return refuse_zero(error, DRIVE_CONFIG_command_zero_units, config->command_zero_units, &port->output);
    }
    scaling->sensor       = config->sensor_reversed != 0u ? reversed(scaling_gain(sensor)) : scaling_gain(sensor);
    scaling->command      = config->command_reversed != 0u ? reversed(scaling_gain(command)) : scaling_gain(command);
    scaling->sensor_zero  = scaling_number(config->sensor_zero_units, port->sensor.full_units);
    scaling->command_zero = scaling->no_current;
#ifndef TRIBO_ARITHMETIC_Q31
    if (scaling->command_zero == 0.0f)
    {
        scaling->command_zero = -0.0f; // adding it keeps the sign of a zero as well
    }
#endif
    return true;
}

#define ROUNDING 1e-5f // relative tolerance that accepts a limit of u exactly at the limit of a range

/// Returns true if the output's range covers `u`, otherwise false with `error`.
static bool has_output(const drive_config_t *config, const port_t *port, float u, drive_config_error_t *error)
{
    const port_range_t *range = &port->output;
    const bool          up    = (u > 0.0f) != (config->command_reversed != 0u);
    const float         room =
        up ? range->high_units - config->command_zero_units : config->command_zero_units - range->low_units;
    const float size = u < 0.0f ? -u : u;
    return !is_limited(range) || size <= room * config->command_n_per_unit * (1.0f + ROUNDING) ||
           refuse(error, DRIVE_CONFIG_command_n_per_unit, config->command_n_per_unit, size / room, 1e6f);
}

static bool has_current(const drive_config_t *config, float u_min, float u_max, drive_config_error_t *error)
{
    const float size = -u_min > u_max ? -u_min : u_max;
    return config->current_max_a == 0.0f ||
           size <= config->current_max_a * config->command_n_per_a * (1.0f + ROUNDING) ||
           refuse(error, DRIVE_CONFIG_current_max_a, config->current_max_a, size / config->command_n_per_a, 1e6f);
}

/// Returns true if the loop rejects a reading at this end of the range, e.g. from a broken wire, otherwise false with `error`.
static bool is_end_refused(const scaling_t      *scaling,
                           const drive_config_t *config,
                           const port_t         *port,
                           const loop_params_t  *params,
                           float                 end_units,
                           drive_config_error_t *error)
{
    const loop_force_t end = scaling_number(end_units, port->sensor.full_units);
    if (!is_limited(&port->sensor) ||
        !tribo_force_is_credible(params, scaling_force(scaling, scaling->sensor_zero, end)))
    {
        return true;
    }
    const float range = end_units - config->sensor_zero_units;
    const float most  = scaling_value(params->TRIBO_N(input_max), config->full_scale_n);
    return refuse(error,
                  DRIVE_CONFIG_sensor_n_per_unit,
                  config->sensor_n_per_unit,
                  most / (range < 0.0f ? -range : range),
                  1e6f);
}

bool scaling_suits(const scaling_t      *scaling,
                   const drive_config_t *config,
                   const port_t         *port,
                   const loop_params_t  *params,
                   drive_config_error_t *error)
{
    const float u_min = scaling_value(params->controller.TRIBO_N(u_min), config->full_scale_n);
    const float u_max = scaling_value(params->controller.TRIBO_N(u_max), config->full_scale_n);
    return (!loop_has_sensor(params) ||
            (is_end_refused(scaling, config, port, params, port->sensor.low_units, error) &&
             is_end_refused(scaling, config, port, params, port->sensor.high_units, error))) &&
           has_output(config, port, u_min, error) && has_output(config, port, u_max, error) &&
           has_current(config, u_min, u_max, error);
}
