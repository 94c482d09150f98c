// The feed-forward without a force sensor in fixed point. Sums over a slide are Q29 in 64 bits: X stays within 2^22
// widths and W within 2^23 FS.

#include "../number/fixed_q31.h"
#include "../number/ranges.h"
#include "learner.h"
#include "words_q31.h"

#include "reference.h"

#define FASTEST NUMBER(3.9) // largest motion in a tick that fits, widths

static bool is_part(uint32_t x)
{
    (void)x;
    return true;
}

static part_t part_exactly(float x)
{
    return fixed_unsigned(x, 32);
}

static float number_of_sum(wide_t x)
{
    return (float)x / 536870912.0f;
}

#include "sensorless.h"
