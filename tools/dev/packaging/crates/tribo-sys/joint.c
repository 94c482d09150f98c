// A joint as Rust sees it: memory whose size Rust knows, and numbers whose types are the same for every compiler. A joint has no pointer, so it may move.

#include "tribo/joint_f32.h"

#define JOINT_BYTES 320u // of Joint in src/lib.rs

_Static_assert(sizeof(tribo_joint_f32_t) <= JOINT_BYTES, "Joint in src/lib.rs is too small");
_Static_assert(_Alignof(tribo_joint_f32_t) <= 8, "Joint in src/lib.rs is not aligned enough");

typedef struct
{
    float sample_time_s, effort_max, travel, breakaway, actuator_pole_rad_per_s, gain;
} joint_config_t;

typedef struct
{
    float    friction, low, high, load, share;
    int32_t  is_learned, cause;
    uint32_t bad_inputs, limited_ticks;
} joint_report_t;

int32_t     tribo_sys_joint_init(tribo_joint_f32_t *joint, const joint_config_t *config);
int32_t     tribo_sys_joint_gain(tribo_joint_f32_t *joint, float gain);
void        tribo_sys_joint_report(const tribo_joint_f32_t *joint, joint_report_t *report);
void        tribo_sys_joint_force(const tribo_joint_f32_t *joint, float *force);
const char *tribo_sys_status_text(int32_t status);
const char *tribo_sys_joint_cause_text(int32_t cause);

int32_t tribo_sys_joint_init(tribo_joint_f32_t *joint, const joint_config_t *config)
{
    const tribo_joint_config_t given = {.sample_time_s           = config->sample_time_s,
                                        .effort_max              = config->effort_max,
                                        .travel                  = config->travel,
                                        .breakaway               = config->breakaway,
                                        .actuator_pole_rad_per_s = config->actuator_pole_rad_per_s,
                                        .gain                    = config->gain};
    return (int32_t)tribo_joint_f32_init(joint, &given);
}

int32_t tribo_sys_joint_gain(tribo_joint_f32_t *joint, float gain)
{
    return (int32_t)tribo_joint_f32_gain(joint, gain);
}

void tribo_sys_joint_report(const tribo_joint_f32_t *joint, joint_report_t *report)
{
    tribo_joint_report_t now;
    tribo_joint_f32_report(joint, &now);
    *report = (joint_report_t){now.friction,
                               now.low,
                               now.high,
                               now.load,
                               now.share,
                               now.is_learned,
                               (int32_t)now.cause,
                               now.bad_inputs,
                               now.limited_ticks};
}

void tribo_sys_joint_force(const tribo_joint_f32_t *joint, float *force)
{
    const tribo_joint_force_t now = tribo_joint_f32_force(joint);
    force[0]                      = now.force;
    force[1]                      = now.low;
    force[2]                      = now.high;
}

const char *tribo_sys_status_text(int32_t status)
{
    return tribo_status_text((tribo_status_t)status);
}

const char *tribo_sys_joint_cause_text(int32_t cause)
{
    return tribo_joint_cause_text((tribo_joint_cause_t)cause);
}
