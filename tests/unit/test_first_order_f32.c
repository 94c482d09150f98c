#include "number/first_order_f32.h"

#include "unity.h"

#include <math.h>

static void test_part_of_a_pole_is_exact_to_a_few_bits(void)
{
    for (float x = 1.0e-9f; x <= 50.0f; x *= 1.37f) // pole times tick
    {
        const double exact = -expm1(-(double)x);
        TEST_ASSERT_DOUBLE_WITHIN(3e-7 * exact, exact, (double)first_order_f32_part(x));
    }
    TEST_ASSERT_DOUBLE_WITHIN(3e-8, -expm1(-0.2), (double)first_order_f32_part(0.2f));
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, -expm1(-0.055), (double)first_order_f32_part(0.055f));
}

#include "runners/test_first_order_f32.inc" // main
