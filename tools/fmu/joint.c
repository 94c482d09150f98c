// The joint without a force sensor as an FMU.

#include "door.h"

#include "tribo/joint_f32.h"

const size_t fmu_door_size = sizeof(tribo_joint_f32_t);

tribo_status_t fmu_door_start(void *door, const double fields[FIELD_COUNT])
{
    const tribo_joint_config_t config = {.sample_time_s           = (float)fields[FIELD_sample_time_s],
                                         .effort_max              = (float)fields[FIELD_effort_max],
                                         .travel                  = (float)fields[FIELD_travel],
                                         .breakaway               = (float)fields[FIELD_breakaway],
                                         .actuator_pole_rad_per_s = (float)fields[FIELD_actuator_pole_rad_per_s],
                                         .gain                    = (float)fields[FIELD_gain]};
    return tribo_joint_f32_init(door, &config);
}

tribo_status_t fmu_door_change(void *door, const double fields[FIELD_COUNT])
{
    return tribo_joint_f32_gain(door, (float)fields[FIELD_gain]);
}

void fmu_door_tick(void *door, double signals[SIGNAL_COUNT])
{
    tribo_joint_f32_load(door, (float)signals[SIGNAL_load]);
    signals[SIGNAL_u] = (double)tribo_joint_f32_step(door,
                                                     (float)signals[SIGNAL_effort],
                                                     (float)signals[SIGNAL_q_ref],
                                                     (float)signals[SIGNAL_q]);
}

void fmu_door_report(void *door, double signals[SIGNAL_COUNT])
{
    tribo_joint_report_t report;
    tribo_joint_f32_report(door, &report);
    const tribo_joint_force_t force = tribo_joint_f32_force(door);
    signals[SIGNAL_friction]        = (double)report.friction;
    signals[SIGNAL_friction_low]    = (double)report.low;
    signals[SIGNAL_friction_high]   = (double)report.high;
    signals[SIGNAL_held_load]       = (double)report.load;
    signals[SIGNAL_force]           = (double)force.force;
    signals[SIGNAL_force_low]       = (double)force.low;
    signals[SIGNAL_force_high]      = (double)force.high;
    signals[SIGNAL_share]           = (double)report.share;
    signals[SIGNAL_is_learned]      = report.is_learned ? 1.0 : 0.0;
    signals[SIGNAL_cause]           = report.cause;
    signals[SIGNAL_bad_inputs]      = report.bad_inputs;
    signals[SIGNAL_limited_ticks]   = report.limited_ticks;
}

void fmu_door_restore(void *door)
{
    tribo_joint_f32_restore(door);
}
