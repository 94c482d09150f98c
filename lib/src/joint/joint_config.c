#include "joint_config.h"

#include "../number/first_order_f32.h"
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

float tribo_joint_led(float gain)
{
    return limit_f32(gain, 0.0f, JOINT_LED);
}

joint_rates_t tribo_joint_config_rates(const tribo_joint_config_t *config)
{
    const float h        = config->sample_time_s;
    const float pole     = config->actuator_pole_rad_per_s;
    const float actuator = pole > 0.0f ? 1.0f / pole : 0.0f;
    const float lag      = actuator + JOINT_LAG_TICKS * h;
    return (joint_rates_t){.jump       = limit_f32(2.0f * h / (JOINT_JUMP_TIME * lag), 0.0f, 1.0f),
                           .level_part = first_order_f32_lag(JOINT_LEVEL_TIME, h),
                           .observer_part =
                               first_order_f32_lag(larger(larger(JOINT_OBSERVER_TIME * lag, JOINT_OBSERVER_TICKS * h),
                                                          JOINT_OBSERVER_LEAST),
                                                   h),
                           .actuator_part = pole > 0.0f ? first_order_f32_part(limit_f32(pole * h, 0.0f, 50.0f)) : 1.0f,
                           .fade_step     = limit_f32(h / JOINT_FADE_TIME, 0.0f, 1.0f),
                           .rest_ticks    = (uint32_t)larger(JOINT_REST_TIME / h, 4.0f)};
}

tribo_joint_force_t tribo_joint_force_of(float effort, float friction, float direction, float more)
{
    const float force = effort - friction * direction;
    const float half  = JOINT_INTERVAL * friction + more;
    return (tribo_joint_force_t){.force = force, .low = force - half, .high = force + half};
}

tribo_joint_report_t tribo_joint_report_of(float friction, float spread, bool is_learned, float most)
{
    const float by = 2.0f * spread + JOINT_MODEL * friction;
    return (tribo_joint_report_t){.friction   = friction,
                                  .low        = is_learned ? larger(friction - by, 0.0f) : 0.0f,
                                  .high       = is_learned ? friction + by : most,
                                  .is_learned = is_learned};
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
