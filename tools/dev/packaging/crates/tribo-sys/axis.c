// A force axis as Rust sees it. In Rust a value may move at any time.

#include "movable_axis.h"

#define AXIS_BYTES 1664u // of Axis in src/lib.rs

_Static_assert(sizeof(movable_axis_t) <= AXIS_BYTES, "Axis in src/lib.rs is too small");
_Static_assert(_Alignof(movable_axis_t) <= 8, "Axis in src/lib.rs is not aligned enough");

typedef struct
{
    float   sample_time_s, u_min_n, u_max_n, input_max_n, usual_force_n;
    float   positive[2], negative[2]; ///< offset_n, slope
    float   gravity_n, arm_lag_s, noise_n;
    float   actuator_pole_rad_per_s, sensor_pole_rad_per_s;
    int32_t controller; ///< tribo_controller_kind_t, without sections
    float   kp, ki_per_s;
} axis_config_t;

typedef struct
{
    float    breakaway_n[2], low_n[2], high_n[2], travel_n, times_less, share;
    uint32_t bad_inputs, limited_ticks, forgotten, warnings;
} axis_report_t;

int32_t     tribo_sys_axis_init(movable_axis_t *axis, const axis_config_t *config);
int32_t     tribo_sys_axis_change(movable_axis_t *axis, const axis_config_t *config);
float       tribo_sys_axis_step(movable_axis_t *axis, float r, float y);
float       tribo_sys_axis_error(movable_axis_t *axis, float r, float y);
float       tribo_sys_axis_command(movable_axis_t *axis, float v);
float       tribo_sys_axis_excess(const movable_axis_t *axis);
void        tribo_sys_axis_report(movable_axis_t *axis, axis_report_t *report);
const char *tribo_sys_axis_warning(uint32_t *warnings);
void        tribo_sys_axis_restore(movable_axis_t *axis);
void        tribo_sys_axis_export(movable_axis_t *axis, uint8_t *bytes);
int32_t     tribo_sys_axis_import(movable_axis_t *axis, const uint8_t *bytes, size_t size);

static tribo_axis_f32_config_t expanded(const axis_config_t *config)
{
    tribo_axis_f32_config_t full             = tribo_axis_f32_config();
    full.sample_time_s                       = config->sample_time_s;
    full.u_min_n                             = config->u_min_n;
    full.u_max_n                             = config->u_max_n;
    full.input_max_n                         = config->input_max_n;
    full.usual_force_n                       = config->usual_force_n;
    full.positive                            = (tribo_breakaway_f32_t){config->positive[0], config->positive[1]};
    full.negative                            = (tribo_breakaway_f32_t){config->negative[0], config->negative[1]};
    full.gravity_n                           = config->gravity_n;
    full.arm_lag_s                           = config->arm_lag_s;
    full.noise_n                             = config->noise_n;
    full.feedforward.actuator_pole_rad_per_s = config->actuator_pole_rad_per_s;
    full.feedforward.sensor_pole_rad_per_s   = config->sensor_pole_rad_per_s;
    full.controller                          = tribo_pi(config->kp, config->ki_per_s);
    full.controller.kind                     = (tribo_controller_kind_t)config->controller;
    return full;
}

int32_t tribo_sys_axis_init(movable_axis_t *axis, const axis_config_t *config)
{
    const tribo_axis_f32_config_t full = expanded(config);
    return (int32_t)movable_axis_init(axis, &full);
}

int32_t tribo_sys_axis_change(movable_axis_t *axis, const axis_config_t *config)
{
    const tribo_axis_f32_config_t full = expanded(config);
    return (int32_t)movable_axis_change(axis, &full);
}

float tribo_sys_axis_step(movable_axis_t *axis, float r, float y)
{
    const float u = tribo_axis_f32_step(movable_axis_here(axis), r, y);
    movable_axis_ran(axis);
    return u;
}

float tribo_sys_axis_error(movable_axis_t *axis, float r, float y)
{
    const float e = tribo_axis_f32_error(movable_axis_here(axis), r, y);
    movable_axis_ran(axis);
    return e;
}

float tribo_sys_axis_command(movable_axis_t *axis, float v)
{
    const float u = tribo_axis_f32_command(movable_axis_here(axis), v);
    movable_axis_ran(axis);
    return u;
}

float tribo_sys_axis_excess(const movable_axis_t *axis)
{
    return axis->axis.excess_n;
}

void tribo_sys_axis_report(movable_axis_t *axis, axis_report_t *report)
{
    tribo_axis_report_t now;
    tribo_axis_f32_report(movable_axis_here(axis), &now);
    *report = (axis_report_t){{now.breakaway_n[0], now.breakaway_n[1]},
                              {now.low_n[0], now.low_n[1]},
                              {now.high_n[0], now.high_n[1]},
                              now.travel_n,
                              now.times_less,
                              now.share,
                              now.bad_inputs,
                              now.limited_ticks,
                              now.forgotten,
                              now.warnings};
}

const char *tribo_sys_axis_warning(uint32_t *warnings)
{
    return tribo_axis_warning(warnings);
}

void tribo_sys_axis_restore(movable_axis_t *axis)
{
    tribo_axis_f32_restore(movable_axis_here(axis));
}

_Static_assert(sizeof(tribo_axis_f32_blob_t) == 104u, "LEARNED_BYTES in src/lib.rs has another size");

void tribo_sys_axis_export(movable_axis_t *axis, uint8_t *bytes)
{
    tribo_axis_f32_blob_t blob;
    tribo_axis_f32_export(movable_axis_here(axis), &blob);
    for (size_t i = 0; i < sizeof blob; i++)
    {
        bytes[i] = ((const uint8_t *)&blob)[i];
    }
}

int32_t tribo_sys_axis_import(movable_axis_t *axis, const uint8_t *bytes, size_t size)
{
    tribo_axis_f32_blob_t blob;
    if (size != sizeof blob)
    {
        return (int32_t)TRIBO_ERR_BLOB_VERSION;
    }
    for (size_t i = 0; i < sizeof blob; i++)
    {
        ((uint8_t *)&blob)[i] = bytes[i];
    }
    return (int32_t)tribo_axis_f32_import(movable_axis_here(axis), &blob);
}
