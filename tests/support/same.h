// Exact comparison of floats; Unity's TEST_ASSERT_EQUAL_FLOAT allows 1e-5 and evaluates its arguments twice.

#ifndef TESTS_SUPPORT_SAME_H
#define TESTS_SUPPORT_SAME_H

#include "unity.h"

#include <stdint.h>
#include <string.h>

static inline uint32_t same_bits(float x)
{
    const float positive_zero = x + 0.0f; // -0 counts as 0
    uint32_t    bits;
    memcpy(&bits, &positive_zero, sizeof bits);
    return bits;
}

#define TEST_ASSERT_SAME_FLOAT(expected, actual) TEST_ASSERT_EQUAL_HEX32(same_bits(expected), same_bits(actual))

#endif
