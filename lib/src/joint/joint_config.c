#include "joint_config.h"

#include "../number/ieee_f32.h"
#include "../number/ranges.h"

tribo_joint_config_t tribo_joint_config(void)
{
    return (tribo_joint_config_t){.gain = JOINT_GAIN};
}

tribo_status_t tribo_joint_config_check(const tribo_joint_config_t *config)
{
    const bool is_fast = config->actuator_pole_rad_per_s == 0.0f;
    if (!sample_time_ok(config->sample_time_s))
    {
        return TRIBO_ERR_SAMPLE_TIME;
    }
    if (!within(config->effort_max, 1.0e-6f, 1.0e6f))
    {
        return TRIBO_ERR_JOINT_EFFORT;
    }
    if (!within(config->travel, 1.0e-9f, 1.0e6f))
    {
        return TRIBO_ERR_JOINT_TRAVEL;
    }
    if (!within(config->breakaway, 0.0f, config->effort_max))
    {
        return TRIBO_ERR_JOINT_BREAKAWAY;
    }
    if (!is_fast && !within(config->actuator_pole_rad_per_s, 1.0e-3f, 1.0e6f))
    {
        return TRIBO_ERR_JOINT_POLE;
    }
    if (!within(config->gain, 0.0f, 1.0f))
    {
        return TRIBO_ERR_JOINT_GAIN;
    }
    const bool is_open = config->wrap == 0.0f;
    return is_open || within(config->wrap, JOINT_WRAP_MIN * config->travel, JOINT_WRAP_MAX) ? TRIBO_OK
                                                                                            : TRIBO_ERR_JOINT_WRAP;
}

const char *tribo_joint_cause_text(tribo_joint_cause_t cause)
{
    switch (cause)
    {
    case TRIBO_JOINT_SOUND:
        return "sound";
    case TRIBO_JOINT_ASTRAY:
        return "astray: with its friction term the joint moved away from its reference: pass gravity and other "
               "loads to tribo_joint_..._load, check the signs of effort and encoder, then restore";
    case TRIBO_JOINT_HUNTING:
        return "hunting: the joint moved back and forth around a resting reference: double travel or lower the gain, "
               "then restore";
    default:
        return "reversed: moving the joint released energy: the sign of effort or encoder is wrong, or your loop "
               "itself rattles; mend it, then restore";
    }
}
