/// Converts numbers of a host to the inputs of a joint in Q31.

#ifndef COMMON_JOINT_INPUTS_H
#define COMMON_JOINT_INPUTS_H

#include "tribo_arithmetic.h"

#include <math.h>

/// Returns the counts of an encoder, which wrap at 32 bits, or `before` for a NaN or an infinity.
static inline int32_t common_joint_counts(double q, int32_t before)
{
    return isfinite(q) ? (int32_t)(uint32_t)(int64_t)fmod(floor(q), 4294967296.0) : before;
}

/// Returns an effort in Q31 of the largest effort, or `otherwise` for a NaN.
static inline int32_t common_joint_effort(double effort, double effort_max, int32_t otherwise)
{
    return isnan(effort) ? otherwise : tribo_q31_of_n(effort, effort_max);
}

#endif
