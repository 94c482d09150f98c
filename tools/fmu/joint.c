// The joint without a force sensor as an FMU.

#include "door.h"

#include "loop/joint_inputs.h"
#include "tribo_arithmetic.h"

#include "tribo/joint_q31.h"

typedef TRIBO(joint, t) joint_t;

const size_t fmu_door_size = sizeof(joint_t);

tribo_status_t fmu_door_start(void *door, const double fields[FIELD_COUNT])
{
    const tribo_joint_config_t config = {.sample_time_s           = (float)fields[FIELD_sample_time_s],
                                         .effort_max              = (float)fields[FIELD_effort_max],
                                         .travel                  = (float)fields[FIELD_travel],
                                         .breakaway               = (float)fields[FIELD_breakaway],
                                         .actuator_pole_rad_per_s = (float)fields[FIELD_actuator_pole_rad_per_s],
                                         .gain                    = (float)fields[FIELD_gain],
                                         .wrap                    = (float)fields[FIELD_wrap]};
    return TRIBO(joint, init)(door, &config);
}

tribo_status_t fmu_door_change(void *door, const double fields[FIELD_COUNT])
{
    return TRIBO(joint, gain)(door, (float)fields[FIELD_gain]);
}

#if TRIBO_IS_Q31

/// Full scale of efforts is effort_max.
static double unit_of(const joint_t *joint)
{
    return (double)joint->params.unit;
}

static tribo_force_t effort_of(const joint_t *joint, double effort, int32_t otherwise)
{
    return common_joint_effort(effort, unit_of(joint), otherwise);
}

static tribo_force_t position_of(double q, int32_t before)
{
    return common_joint_counts(q, before);
}

static void note_bad(joint_t *joint, const double signals[SIGNAL_COUNT])
{
    common_count_bad(&joint->bad_inputs, !isfinite(signals[SIGNAL_load]));
    common_count_bad(&joint->bad_inputs,
                     !isfinite(signals[SIGNAL_effort]) || !isfinite(signals[SIGNAL_q_ref]) ||
                         !isfinite(signals[SIGNAL_q]));
}

#else

static double unit_of(const joint_t *joint)
{
    (void)joint;
    return 1.0;
}

/// The library counts what is no number.
static tribo_force_t effort_of(const joint_t *joint, double effort, float otherwise)
{
    (void)joint, (void)otherwise;
    return (float)effort;
}

static tribo_force_t position_of(double q, float before)
{
    (void)before;
    return (float)q;
}

static void note_bad(joint_t *joint, const double signals[SIGNAL_COUNT])
{
    (void)joint, (void)signals;
}

#endif

void fmu_door_tick(void *door, double signals[SIGNAL_COUNT])
{
    joint_t *const joint = door;
    note_bad(joint, signals);
    TRIBO(joint, load)(joint, effort_of(joint, signals[SIGNAL_load], joint->load));
    const tribo_force_t u = TRIBO(joint, step)(joint,
                                               effort_of(joint, signals[SIGNAL_effort], 0),
                                               position_of(signals[SIGNAL_q_ref], joint->q_ref),
                                               position_of(signals[SIGNAL_q], joint->q));
    signals[SIGNAL_u]     = tribo_force_n(u, unit_of(joint));
}

void fmu_door_report(void *door, double signals[SIGNAL_COUNT])
{
    tribo_joint_report_t report;
    TRIBO(joint, report)(door, &report);
    const tribo_joint_force_t force = TRIBO(joint, force)(door);
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
    TRIBO(joint, restore)(door);
}
