#include "tribo/joint_f32.h"

#include "../number/first_order_f32.h"
#include "../number/words_f32.h"
#include "joint_config.h"

#include <stddef.h>

typedef float position_t;
typedef float way_t;
typedef float long_t;

#define SMALLEST      1.0e-30f
#define POSITION_MAX  1.0e9f
#define TURNS_MAX     8.0e6f // a float beyond has no fraction
#define EFFORT_MAX    1.0e9f
#define DIRECTION_ONE 1.0f
#define SHARE_UNIT    1.0f

#define check_config tribo_joint_config_check

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

static float part_of(float x)
{
    return x;
}

/// An effort in the config's unit.
static float in_units(const tribo_joint_f32_t *joint, force_t effort)
{
    (void)joint;
    return effort;
}

static void set_units(tribo_joint_f32_t *joint, const tribo_joint_config_t *config)
{
    tribo_joint_f32_params_t *const params = &joint->params;

    joint->friction    = config->breakaway;
    params->effort_max = config->effort_max;
    params->half       = 0.5f * config->travel;
    params->fastest    = JOINT_FASTEST * config->travel;
    params->wrap       = config->wrap;
    params->per_wrap   = config->wrap > 0.0f ? 1.0f / config->wrap : 0.0f;
}

#include "joint.h"
