/// Converts numbers of a host to inputs in Q31, which has no word for a NaN or an infinity.

#ifndef COMMON_JOINT_INPUTS_H
#define COMMON_JOINT_INPUTS_H

#include "tribo_arithmetic.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/// Returns the counts of an encoder, which wrap at 32 bits, or `before` for a NaN or an infinity.
static inline int32_t common_joint_counts(double q, int32_t before)
{
    return isfinite(q) ? (int32_t)(uint32_t)(int64_t)fmod(floor(q), 4294967296.0) : before;
}

/// Returns an effort in Q31 of the largest effort, or `otherwise` for a NaN or an infinity.
static inline int32_t common_joint_effort(double effort, double effort_max, int32_t otherwise)
{
    return isfinite(effort) ? tribo_q31_of_n(effort, effort_max) : otherwise;
}

/// Counts a bad input that Q31 does not show to the library. Float32 shows it.
static inline void common_count_bad(uint32_t *bad_inputs, bool is_bad)
{
    *bad_inputs += is_bad && *bad_inputs < UINT32_MAX ? 1u : 0u;
}

#endif
