// A force axis as Rust sees it, in one arithmetic: axis_q31.c is its other one. In Rust a value may move at any time.

#include "movable_axis.h"

#ifdef TRIBO_ARITHMETIC_Q31
#define SYS_AXIS(verb) tribo_sys_axis_q31_##verb
#else
#define SYS_AXIS(verb) tribo_sys_axis_f32_##verb
#endif

#define AXIS_BYTES 1792u // of AxisF32 and AxisQ31 in src/lib.rs

_Static_assert(sizeof(movable_axis_t) <= AXIS_BYTES, "an axis in src/lib.rs is too small");
_Static_assert(_Alignof(movable_axis_t) <= 8, "an axis in src/lib.rs is not aligned enough");

/// Kinds of tribo_controller_kind_t, and one more.
enum
{
    CONTROLLER_PAPER = 4
};

typedef struct
{
    int32_t                    kind;
    float                      kp, ki_per_s;
    uint32_t                   section_count;
    tribo_biquad_f32_section_t sections[TRIBO_BIQUAD_SECTIONS_MAX];
} controller_t;

typedef struct
{
    float        sample_time_s, u_min_n, u_max_n, input_max_n, usual_force_n;
    float        positive[2], negative[2]; ///< offset_n, slope
    float        gravity_n, arm_lag_s, noise_n;
    float        actuator_pole_rad_per_s, sensor_pole_rad_per_s, presliding_n, still_time_s;
    controller_t controller;
} axis_config_t;

typedef struct
{
    float    breakaway_n[2], low_n[2], high_n[2], breakaway_factor, travel_n, times_less, share;
    uint32_t bad_inputs, limited_ticks, forgotten, late, warnings;
} axis_report_t;

int32_t         SYS_AXIS(init)(movable_axis_t *axis, const axis_config_t *config, float full_scale_n);
int32_t         SYS_AXIS(change)(movable_axis_t *axis, const axis_config_t *config);
movable_force_t SYS_AXIS(step)(movable_axis_t *axis, movable_force_t r, movable_force_t y);
movable_force_t SYS_AXIS(error)(movable_axis_t *axis, movable_force_t r, movable_force_t y);
movable_force_t SYS_AXIS(command)(movable_axis_t *axis, movable_force_t v);
movable_force_t SYS_AXIS(excess)(const movable_axis_t *axis);
void            SYS_AXIS(report)(movable_axis_t *axis, axis_report_t *report);
void            SYS_AXIS(rest)(movable_axis_t *axis);
void            SYS_AXIS(restore)(movable_axis_t *axis);
void            SYS_AXIS(export)(movable_axis_t *axis, uint8_t *bytes);
int32_t         SYS_AXIS(import)(movable_axis_t *axis, const uint8_t *bytes, size_t size);

static tribo_axis_controller_t controller_of(const controller_t *controller)
{
    switch (controller->kind)
    {
    case TRIBO_CONTROLLER_PI:
        return tribo_pi(controller->kp, controller->ki_per_s);
    case TRIBO_CONTROLLER_SECTIONS:
        return tribo_sections(controller->sections, controller->section_count);
    case TRIBO_CONTROLLER_OWN:
        return tribo_own();
    case CONTROLLER_PAPER:
        return tribo_paper();
    default:
        return (tribo_axis_controller_t){.kind = TRIBO_CONTROLLER_NONE};
    }
}

/// The config's sections are those of `given`.
static tribo_axis_f32_config_t expanded(const axis_config_t *given)
{
    tribo_axis_f32_config_t config             = tribo_axis_f32_config();
    config.sample_time_s                       = given->sample_time_s;
    config.u_min_n                             = given->u_min_n;
    config.u_max_n                             = given->u_max_n;
    config.input_max_n                         = given->input_max_n;
    config.usual_force_n                       = given->usual_force_n;
    config.positive                            = (tribo_breakaway_f32_t){given->positive[0], given->positive[1]};
    config.negative                            = (tribo_breakaway_f32_t){given->negative[0], given->negative[1]};
    config.gravity_n                           = given->gravity_n;
    config.arm_lag_s                           = given->arm_lag_s;
    config.noise_n                             = given->noise_n;
    config.feedforward.actuator_pole_rad_per_s = given->actuator_pole_rad_per_s;
    config.feedforward.sensor_pole_rad_per_s   = given->sensor_pole_rad_per_s;
    config.feedforward.presliding_n            = given->presliding_n;
    config.feedforward.still_time_s            = given->still_time_s;
    config.controller                          = controller_of(&given->controller);
    return config;
}

int32_t SYS_AXIS(init)(movable_axis_t *axis, const axis_config_t *config, float full_scale_n)
{
    const tribo_axis_f32_config_t full = expanded(config);
    return (int32_t)movable_axis_init(axis, &full, full_scale_n);
}

int32_t SYS_AXIS(change)(movable_axis_t *axis, const axis_config_t *config)
{
    const tribo_axis_f32_config_t full = expanded(config);
    return (int32_t)movable_axis_change(axis, &full);
}

movable_force_t SYS_AXIS(step)(movable_axis_t *axis, movable_force_t r, movable_force_t y)
{
    const movable_force_t u = MOVABLE(axis, step)(movable_axis_here(axis), r, y);
    movable_axis_ran(axis);
    return u;
}

movable_force_t SYS_AXIS(error)(movable_axis_t *axis, movable_force_t r, movable_force_t y)
{
    const movable_force_t e = MOVABLE(axis, error)(movable_axis_here(axis), r, y);
    movable_axis_ran(axis);
    return e;
}

movable_force_t SYS_AXIS(command)(movable_axis_t *axis, movable_force_t v)
{
    const movable_force_t u = MOVABLE(axis, command)(movable_axis_here(axis), v);
    movable_axis_ran(axis);
    return u;
}

movable_force_t SYS_AXIS(excess)(const movable_axis_t *axis)
{
    return MOVABLE(axis, excess)(&axis->axis);
}

void SYS_AXIS(report)(movable_axis_t *axis, axis_report_t *report)
{
    tribo_axis_report_t now;
    MOVABLE(axis, report)(movable_axis_here(axis), &now);
    *report = (axis_report_t){{now.breakaway_n[0], now.breakaway_n[1]},
                              {now.low_n[0], now.low_n[1]},
                              {now.high_n[0], now.high_n[1]},
                              now.breakaway_factor,
                              now.travel_n,
                              now.times_less,
                              now.share,
                              now.bad_inputs,
                              now.limited_ticks,
                              now.forgotten,
                              now.late,
                              now.warnings};
}

void SYS_AXIS(rest)(movable_axis_t *axis)
{
    MOVABLE(axis, rest)(movable_axis_here(axis));
}

void SYS_AXIS(restore)(movable_axis_t *axis)
{
    MOVABLE(axis, restore)(movable_axis_here(axis));
}

_Static_assert(sizeof(MOVABLE(axis, blob_t)) == 108u, "LEARNED_BYTES in src/lib.rs has another size");

void SYS_AXIS(export)(movable_axis_t *axis, uint8_t *bytes)
{
    MOVABLE(axis, blob_t) blob;
    MOVABLE(axis, export)(movable_axis_here(axis), &blob);
    for (size_t i = 0; i < sizeof blob; i++)
    {
        bytes[i] = ((const uint8_t *)&blob)[i];
    }
}

int32_t SYS_AXIS(import)(movable_axis_t *axis, const uint8_t *bytes, size_t size)
{
    MOVABLE(axis, blob_t) blob;
    if (size != sizeof blob)
    {
        return (int32_t)TRIBO_ERR_BLOB_VERSION;
    }
    for (size_t i = 0; i < sizeof blob; i++)
    {
        ((uint8_t *)&blob)[i] = bytes[i];
    }
    return (int32_t)MOVABLE(axis, import)(movable_axis_here(axis), &blob);
}

#ifdef TRIBO_ARITHMETIC_Q31

int32_t tribo_sys_axis_q31_learn(movable_axis_t *axis);

int32_t tribo_sys_axis_q31_learn(movable_axis_t *axis)
{
    return tribo_axis_q31_learn(movable_axis_here(axis));
}

#endif
