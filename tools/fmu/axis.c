// The force axis as an FMU, with a PI.

#include "door.h"

#include "loop/movable_axis.h"

const size_t fmu_door_size = sizeof(movable_axis_t);

static tribo_axis_f32_config_t config_of(const double fields[FIELD_COUNT])
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
    config.controller                          = tribo_pi((float)fields[FIELD_kp], (float)fields[FIELD_ki_per_s]);
    return config;
}

tribo_status_t fmu_door_start(void *door, const double fields[FIELD_COUNT])
{
    const tribo_axis_f32_config_t config = config_of(fields);
    return movable_axis_init(door, &config, 0.0f);
}

tribo_status_t fmu_door_change(void *door, const double fields[FIELD_COUNT])
{
    const tribo_axis_f32_config_t config = config_of(fields);
    return movable_axis_change(door, &config);
}

void fmu_door_tick(void *door, double signals[SIGNAL_COUNT])
{
    tribo_axis_f32_t *const axis = movable_axis_here(door);
    signals[SIGNAL_u_n] = (double)tribo_axis_f32_step(axis, (float)signals[SIGNAL_r_n], (float)signals[SIGNAL_y_n]);
    movable_axis_ran(door);
}

void fmu_door_report(void *door, double signals[SIGNAL_COUNT])
{
    tribo_axis_report_t report;
    tribo_axis_f32_report(movable_axis_here(door), &report);
    signals[SIGNAL_breakaway_positive_n] = (double)report.breakaway_n[0];
    signals[SIGNAL_breakaway_negative_n] = (double)report.breakaway_n[1];
    signals[SIGNAL_low_positive_n]       = (double)report.low_n[0];
    signals[SIGNAL_low_negative_n]       = (double)report.low_n[1];
    signals[SIGNAL_high_positive_n]      = (double)report.high_n[0];
    signals[SIGNAL_high_negative_n]      = (double)report.high_n[1];
    signals[SIGNAL_travel_n]             = (double)report.travel_n;
    signals[SIGNAL_times_less]           = (double)report.times_less;
    signals[SIGNAL_share]                = (double)report.share;
    signals[SIGNAL_bad_inputs]           = report.bad_inputs;
    signals[SIGNAL_limited_ticks]        = report.limited_ticks;
    signals[SIGNAL_warnings]             = report.warnings;
}

void fmu_door_restore(void *door)
{
    tribo_axis_f32_restore(movable_axis_here(door));
}
