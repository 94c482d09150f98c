// The force axis as an FMU. values.h defines FMU_CONTROLLER_PI, _SECTIONS, _PAPER or _OWN; of sections also FMU_SECTIONS, how many, whose fields
// stand in a row.

#include "door.h"

#include "loop/joint_inputs.h"
#include "loop/movable_axis.h"
#include "tribo_arithmetic.h"

const size_t fmu_door_size = sizeof(movable_axis_t);

/// `sections` is room for them.
static tribo_axis_controller_t controller_of(const double fields[FIELD_COUNT], tribo_biquad_f32_section_t *sections)
{
    (void)fields, (void)sections;
#ifdef FMU_CONTROLLER_PI
    return tribo_pi((float)fields[FIELD_kp], (float)fields[FIELD_ki_per_s]);
#elif defined(FMU_CONTROLLER_SECTIONS)
    for (unsigned i = 0; i < FMU_SECTIONS; i++)
    {
        const double *const x = &fields[FIELD_sections_0_b0 + 5u * i];
        sections[i] = (tribo_biquad_f32_section_t){(float)x[0], (float)x[1], (float)x[2], (float)x[3], (float)x[4]};
    }
    return tribo_sections(sections, FMU_SECTIONS);
#elif defined(FMU_CONTROLLER_PAPER)
    return tribo_paper();
#else
    return tribo_own();
#endif
}

static tribo_axis_f32_config_t config_of(const double fields[FIELD_COUNT], tribo_biquad_f32_section_t *sections)
{
    tribo_axis_f32_config_t config = tribo_axis_f32_config();
    config.sample_time_s           = (float)fields[FIELD_sample_time_s];
    config.u_min_n                 = (float)fields[FIELD_u_min_n];
    config.u_max_n                 = (float)fields[FIELD_u_max_n];
    config.input_max_n             = (float)fields[FIELD_input_max_n];
    config.usual_force_n           = (float)fields[FIELD_usual_force_n];
    config.positive.offset_n       = (float)fields[FIELD_positive_offset_n];
    config.positive.slope          = (float)fields[FIELD_positive_slope];
    config.negative.offset_n       = (float)fields[FIELD_negative_offset_n];
    config.negative.slope          = (float)fields[FIELD_negative_slope];
    config.gravity_n               = (float)fields[FIELD_gravity_n];
    config.arm_lag_s               = (float)fields[FIELD_arm_lag_s];
    config.noise_n                 = (float)fields[FIELD_noise_n];

    config.feedforward.actuator_pole_rad_per_s = (float)fields[FIELD_actuator_pole_rad_per_s];
    config.feedforward.sensor_pole_rad_per_s   = (float)fields[FIELD_sensor_pole_rad_per_s];
    config.feedforward.presliding_n            = (float)fields[FIELD_presliding_n];
    config.feedforward.still_time_s            = (float)fields[FIELD_still_time_s];
    config.controller                          = controller_of(fields, sections);
    return config;
}

static float full_scale_n(const double fields[FIELD_COUNT])
{
    (void)fields;
    return TRIBO_EITHER(0.0f, (float)fields[FIELD_full_scale_n]);
}

tribo_status_t fmu_door_start(void *door, const double fields[FIELD_COUNT])
{
    tribo_biquad_f32_section_t    sections[TRIBO_BIQUAD_SECTIONS_MAX];
    const tribo_axis_f32_config_t config = config_of(fields, sections);
    return movable_axis_init(door, &config, full_scale_n(fields));
}

tribo_status_t fmu_door_change(void *door, const double fields[FIELD_COUNT])
{
    tribo_biquad_f32_section_t    sections[TRIBO_BIQUAD_SECTIONS_MAX];
    const tribo_axis_f32_config_t config = config_of(fields, sections);
    return movable_axis_change(door, &config);
}

void fmu_door_tick(void *door, double signals[SIGNAL_COUNT])
{
    TRIBO(axis, t) *const axis   = movable_axis_here(door);
    const double          full_n = (double)axis->params.full_scale_n;
    const tribo_force_t   r      = tribo_force_of_n(signals[SIGNAL_r_n], full_n);
    const tribo_force_t   y      = tribo_force_of_n(signals[SIGNAL_y_n], full_n);
#ifdef FMU_CONTROLLER_OWN
    signals[SIGNAL_e_n] = tribo_force_n(TRIBO(axis, error)(axis, r, y), full_n);
#if TRIBO_IS_Q31
    const double v_n = isfinite(signals[SIGNAL_v_n]) ? signals[SIGNAL_v_n] : 0.0;
    common_count_bad(&axis->bad_inputs, !isfinite(signals[SIGNAL_v_n]));
#else
    const double v_n = signals[SIGNAL_v_n];
#endif
    const tribo_force_t v    = tribo_force_of_n(v_n, full_n);
    signals[SIGNAL_u_n]      = tribo_force_n(TRIBO(axis, command)(axis, v), full_n);
    signals[SIGNAL_excess_n] = tribo_force_n(TRIBO(axis, excess)(axis), full_n);
#else
    signals[SIGNAL_u_n] = tribo_force_n(TRIBO(axis, step)(axis, r, y), full_n);
#endif
#if TRIBO_IS_Q31
    (void)tribo_axis_q31_learn(axis);
#endif
    movable_axis_ran(door);
}

void fmu_door_report(void *door, double signals[SIGNAL_COUNT])
{
    tribo_axis_report_t report;
    TRIBO(axis, report)(movable_axis_here(door), &report);
    signals[SIGNAL_breakaway_positive_n] = (double)report.breakaway_n[0];
    signals[SIGNAL_breakaway_negative_n] = (double)report.breakaway_n[1];
    signals[SIGNAL_low_positive_n]       = (double)report.low_n[0];
    signals[SIGNAL_low_negative_n]       = (double)report.low_n[1];
    signals[SIGNAL_high_positive_n]      = (double)report.high_n[0];
    signals[SIGNAL_high_negative_n]      = (double)report.high_n[1];
    signals[SIGNAL_breakaway_factor]     = (double)report.breakaway_factor;
    signals[SIGNAL_travel_n]             = (double)report.travel_n;
    signals[SIGNAL_times_less]           = (double)report.times_less;
    signals[SIGNAL_share]                = (double)report.share;
    signals[SIGNAL_bad_inputs]           = report.bad_inputs;
    signals[SIGNAL_limited_ticks]        = report.limited_ticks;
    signals[SIGNAL_warnings]             = report.warnings;
}

void fmu_door_restore(void *door)
{
    TRIBO(axis, restore)(movable_axis_here(door));
}
