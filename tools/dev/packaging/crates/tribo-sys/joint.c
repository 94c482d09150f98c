// A joint as Rust sees it, in one arithmetic: joint_q31.c is its other one. Memory has a size that Rust knows, numbers have types that are the
// same for every compiler. A joint has no pointer, so it may move, and what a tick needs is the library's own.

#ifdef TRIBO_ARITHMETIC_Q31
#include "tribo/joint_q31.h"
#define JOINT(verb)     tribo_joint_q31_##verb
#define SYS_JOINT(verb) tribo_sys_joint_q31_##verb
#else
#include "tribo/joint_f32.h"
#define JOINT(verb)     tribo_joint_f32_##verb
#define SYS_JOINT(verb) tribo_sys_joint_f32_##verb
#endif

#define JOINT_BYTES 320u // of JointF32 and JointQ31 in src/lib.rs

typedef JOINT(t) joint_t;

_Static_assert(sizeof(joint_t) <= JOINT_BYTES, "a joint in src/lib.rs is too small");
_Static_assert(_Alignof(joint_t) <= 8, "a joint in src/lib.rs is not aligned enough");

typedef struct
{
    float sample_time_s, effort_max, travel, breakaway, actuator_pole_rad_per_s, gain, wrap;
} joint_config_t;

typedef struct
{
    float    friction, low, high, load, share;
    int32_t  is_learned, cause;
    uint32_t bad_inputs, limited_ticks;
} joint_report_t;

int32_t SYS_JOINT(init)(joint_t *joint, const joint_config_t *config);
int32_t SYS_JOINT(gain)(joint_t *joint, float gain);
void    SYS_JOINT(report)(const joint_t *joint, joint_report_t *report);
void    SYS_JOINT(force)(const joint_t *joint, float *force);

int32_t SYS_JOINT(init)(joint_t *joint, const joint_config_t *config)
{
    const tribo_joint_config_t given = {.sample_time_s           = config->sample_time_s,
                                        .effort_max              = config->effort_max,
                                        .travel                  = config->travel,
                                        .breakaway               = config->breakaway,
                                        .actuator_pole_rad_per_s = config->actuator_pole_rad_per_s,
                                        .gain                    = config->gain,
                                        .wrap                    = config->wrap};
    return (int32_t)JOINT(init)(joint, &given);
}

int32_t SYS_JOINT(gain)(joint_t *joint, float gain)
{
    return (int32_t)JOINT(gain)(joint, gain);
}

void SYS_JOINT(report)(const joint_t *joint, joint_report_t *report)
{
    tribo_joint_report_t now;
    JOINT(report)(joint, &now);
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

void SYS_JOINT(force)(const joint_t *joint, float *force)
{
    const tribo_joint_force_t now = JOINT(force)(joint);
    force[0]                      = now.force;
    force[1]                      = now.low;
    force[2]                      = now.high;
}
