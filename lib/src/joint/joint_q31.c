#include "tribo/joint_q31.h"

#include "../number/first_order_f32.h"
#include "../number/fixed_q31.h"
#include "../number/words_q31.h"
#include "joint_config.h"

#include <stddef.h>

typedef int32_t position_t; ///< counts, which may wrap
typedef int32_t way_t;      ///< Q12 of a count
typedef int64_t long_t;

#define SMALLEST      1
#define COUNT         4096                // Q12
#define WAY_MAX       (1 << 30)           // Q12 of a count
#define TRAVEL_MAX    1.0e4f              // counts
#define LONG_MAX_WAY  (UINT32_C(1) << 6)  // times 2^32
#define LONG_MAX_WORK (UINT32_C(1) << 29) // times 2^32
#define WORK_FRACTION 256                 // of Q31, so that a slide's work fits 64 bits
#define WORK_SHIFT    23
#define DIRECTION_ONE (1 << 30)
#define EFFORT_UNIT   (1.0f / 2147483648.0f)
#define SHARE_UNIT    (0.5f * EFFORT_UNIT)

static inline bool position_is_bad(position_t q)
{
    (void)q;
    return false;
}

static inline bool effort_is_bad(force_t effort)
{
    (void)effort;
    return false;
}

/// a - b; if positions wrap at a turn, the short way.
static inline way_t way_between(const tribo_joint_q31_params_t *params, position_t a, position_t b)
{
    const int32_t wrap   = params->wrap;
    int32_t       counts = difference_q31(a, b);
    if (wrap != 0 && exceeds_q31(counts, wrap / 2))
    {
        counts %= wrap; // of the sign of counts
        counts -= exceeds_q31(counts, wrap / 2) ? (counts < 0 ? -wrap : wrap) : 0;
    }
    return COUNT * limit_q31(counts, -WAY_MAX / COUNT, WAY_MAX / COUNT);
}

/// By a unit at least: what a low pass stops short of would be a motion for ever.
static inline way_t way_track(way_t x, way_t input, uint32_t part)
{
    const int32_t left = difference_q31(input, x);
    const int32_t step = part_of_q31(left, part);
    return sum_q31(x, step != 0 ? step : (left > 0) - (left < 0));
}

static inline force_t force_track(force_t x, force_t input, uint32_t part)
{
    return plus(x, part != UINT32_MAX ? part_of_q31(minus(input, x), part) : minus(input, x));
}

static inline int32_t direction_track(int32_t x, int8_t side, uint32_t part)
{
    return side != 0 ? first_order_q31_step(x, side * DIRECTION_ONE, part) : x - part_of_q31(x, part / 8u);
}

static inline long_t work_of(force_t effort, way_t moved)
{
    return tribo_q31_multiply(effort / WORK_FRACTION, moved);
}

/// W/X in Q31; both are scaled until X fits 32 bits.
static inline force_t mean_effort(long_t work, long_t travel)
{
    uint64_t over  = (uint64_t)(work < 0 ? -work : work) >> WORK_SHIFT;
    uint64_t under = (uint64_t)travel;
    while (under > UINT32_MAX)
    {
        under >>= 1;
        over >>= 1;
    }
    const int32_t mean = over < under ? (int32_t)ratio_q31((uint32_t)over, (uint32_t)under) : INT32_MAX;
    return work < 0 ? -mean : mean;
}

/// True if x is beyond +-most 2^32.
static inline bool long_beyond(long_t x, uint32_t most)
{
    return (uint32_t)((uint64_t)x >> 32) + most >= 2u * most;
}

/// True where the sums of the slide would soon overflow.
static inline bool is_too_long(const tribo_joint_q31_slide_t *slide)
{
    return long_beyond(slide->travel, LONG_MAX_WAY) || long_beyond(slide->work, LONG_MAX_WORK) ||
           long_beyond(slide->slow_work, LONG_MAX_WORK);
}

static inline bool is_no_number(way_t x)
{
    (void)x;
    return false;
}

/// Every integer is a credible state.
static inline bool is_corrupt(const tribo_joint_q31_t *x)
{
    (void)x;
    return false;
}

/// Of a size of 0 or more.
static inline force_t halved(force_t size, uint32_t times)
{
    return size >> times;
}

static uint32_t part_of(float x)
{
    return fixed_unsigned(x, 32);
}

static float in_units(const tribo_joint_q31_t *joint, force_t effort)
{
    return (float)effort * EFFORT_UNIT * joint->params.unit;
}

static tribo_status_t check_config(const tribo_joint_config_t *config)
{
    const tribo_status_t status = tribo_joint_config_check(config);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!within(config->travel, 1.0f, TRAVEL_MAX))
    {
        return TRIBO_ERR_JOINT_TRAVEL;
    }
    return config->wrap == (float)(int32_t)config->wrap ? TRIBO_OK : TRIBO_ERR_JOINT_WRAP;
}

static void set_units(tribo_joint_q31_t *joint, const tribo_joint_config_t *config)
{
    tribo_joint_q31_params_t *const params = &joint->params;

    joint->friction    = fixed_force(config->breakaway, config->effort_max);
    params->effort_max = INT32_MAX;
    params->half       = (int32_t)(0.5f * config->travel * (float)COUNT);
    params->fastest    = params->half < WAY_MAX / 2000 ? 2000 * params->half : WAY_MAX - 1;
    params->wrap       = (int32_t)config->wrap;
    params->unit       = config->effort_max;
}

#include "joint.h"
