#include "tribo/joint_f32.h"

#include "../number/first_order_f32.h"
#include "../number/words_f32.h"
#include "joint_config.h"

#include <stddef.h>

typedef float position_t;
typedef float way_t;
typedef float long_t;

#define SMALLEST     1.0e-30f
#define POSITION_MAX 1.0e9f
#define TURNS_MAX    8.0e6f // a float beyond has no fraction
#define EFFORT_MAX   1.0e9f

static inline bool position_is_bad(position_t q)
{
    return exceeds(q, POSITION_MAX);
}

static inline bool effort_is_bad(force_t effort)
{
    return exceeds(effort, EFFORT_MAX);
}

/// a - b; if positions wrap, the short way.
static inline way_t way_between(const tribo_joint_f32_params_t *params, position_t a, position_t b)
{
    const float way = a - b;
    if (params->wrap == 0.0f)
    {
        return way;
    }
    const float turns = limit_f32(way * params->per_wrap, -TURNS_MAX, TURNS_MAX);
    return way - params->wrap * (float)(int32_t)(turns + (turns < 0.0f ? -0.5f : 0.5f));
}

static inline way_t way_plus(way_t a, way_t b)
{
    return a + b;
}

static inline way_t way_size(way_t x)
{
    return magnitude(x);
}

static inline bool way_beyond(way_t x, way_t most)
{
    return exceeds(x, most);
}

static inline way_t way_track(way_t x, way_t input, float part)
{
    return first_order_f32_step(x, input, part);
}

static inline force_t force_track(force_t x, force_t input, float part)
{
    return first_order_f32_step(x, input, part);
}

static inline float direction_track(float x, int8_t side, float part)
{
    return side != 0 ? first_order_f32_step(x, (float)side, part) : x - 0.125f * part * x;
}

static inline long_t work_of(force_t effort, way_t moved)
{
    return effort * moved;
}

static inline force_t mean_effort(long_t work, long_t travel)
{
    return work / travel;
}

static inline bool is_too_long(const tribo_joint_f32_slide_t *slide)
{
    (void)slide;
    return false;
}

/// True for a number that no later one can bring back.
static inline bool is_no_number(float x)
{
    return exceeds(x, FLT_MAX);
}

/// True if one of the states that last beyond a tick is infinite, no number, or far beyond what inputs can make it. Asked
/// where u is at its limit and after a slide, as it takes 30 instructions.
static inline bool is_corrupt(const tribo_joint_f32_t *x)
{
    const float most   = x->params.effort_max;
    const float terms  = x->friction + x->spread + x->level + x->term + x->kept + x->lagged + most * x->direction;
    const float loaded = x->load + x->offset + x->slide.effort;
    return exceeds(terms, 16.0f * most) || exceeds(loaded, 4.0f * EFFORT_MAX);
}

static inline force_t halved(force_t size, uint32_t times)
{
    for (uint32_t i = times; i > 0u; i--)
    {
        size *= 0.5f;
    }
    return size;
}

static inline fade_t fade_step(fade_t share, bool rises, fade_t step)
{
    const fade_t next = rises ? share + 0.125f * step : share - step;
    if (rises)
    {
        return next < 1.0f ? next : 1.0f;
    }
    return next > 0.0f ? next : 0.0f;
}

#include "joint.h"

tribo_status_t tribo_joint_f32_init(tribo_joint_f32_t *joint, const tribo_joint_config_t *config)
{
    if (joint == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    const tribo_status_t status = tribo_joint_config_check(config);
    if (status != TRIBO_OK)
    {
        return status;
    }
    const joint_rates_t rates = tribo_joint_config_rates(config);
    *joint                    = (tribo_joint_f32_t){.params   = {.effort_max    = config->effort_max,
                                                                 .half          = 0.5f * config->travel,
                                                                 .fastest       = JOINT_FASTEST * config->travel,
                                                                 .wrap          = config->wrap,
                                                                 .per_wrap      = config->wrap > 0.0f ? 1.0f / config->wrap : 0.0f,
                                                                 .gain          = config->gain,
                                                                 .led           = tribo_joint_led(config->gain),
                                                                 .jump          = rates.jump,
                                                                 .level_part    = rates.level_part,
                                                                 .observer_part = rates.observer_part,
                                                                 .actuator_part = rates.actuator_part,
                                                                 .fade_step     = rates.fade_step,
                                                                 .rest_ticks    = (uint32_t)rates.rest_ticks},
                                                    .made     = 1,
                                                    .share    = 1.0f,
                                                    .friction = config->breakaway,
                                                    .still    = (uint32_t)rates.rest_ticks,
                                                    .alive    = (uint32_t)rates.rest_ticks};
    return TRIBO_OK;
}

tribo_status_t tribo_joint_f32_gain(tribo_joint_f32_t *joint, float gain)
{
    if (!within(gain, 0.0f, 1.0f))
    {
        return TRIBO_ERR_JOINT_GAIN;
    }
    joint->params.gain = gain;
    joint->params.led  = tribo_joint_led(gain);
    return TRIBO_OK;
}

tribo_joint_force_t tribo_joint_f32_force(const tribo_joint_f32_t *joint)
{
    return tribo_joint_force_of(joint->slide.effort,
                                joint->friction,
                                joint->direction,
                                joint->learned != 0u ? 0.0f : joint->params.effort_max);
}

void tribo_joint_f32_report(const tribo_joint_f32_t *joint, tribo_joint_report_t *report)
{
    *report = tribo_joint_report_of(joint->friction, joint->spread, joint->learned != 0u, joint->params.effort_max);

    report->load          = joint->offset;
    report->share         = joint->share;
    report->cause         = (tribo_joint_cause_t)joint->cause;
    report->bad_inputs    = joint->bad_inputs;
    report->limited_ticks = joint->limited_ticks;
}
