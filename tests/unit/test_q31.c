#include "tribo/q31.h"

#include "random.h"
#include "unity.h"

#include <stdio.h>

static uint32_t saturated;

void setUp(void)
{
    saturated = 0;
}

static void test_q31_saturates_to_a_symmetric_range_and_counts(void)
{
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, tribo_q31_saturate(INT32_MAX, &saturated));
    TEST_ASSERT_EQUAL_INT32(-INT32_MAX, tribo_q31_saturate(-(int64_t)INT32_MAX, &saturated));
    TEST_ASSERT_EQUAL_INT32(0, tribo_q31_saturate(0, &saturated));
    TEST_ASSERT_EQUAL_UINT32(0, saturated);
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, tribo_q31_saturate(INT64_C(1) << 31, &saturated));
    TEST_ASSERT_EQUAL_INT32(-INT32_MAX, tribo_q31_saturate(INT32_MIN, &saturated));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, tribo_q31_saturate(INT64_MAX, &saturated));
    TEST_ASSERT_EQUAL_INT32(-INT32_MAX, tribo_q31_saturate(INT64_MIN, &saturated));
    TEST_ASSERT_EQUAL_UINT32(4, saturated);
    saturated = UINT32_MAX;
    (void)tribo_q31_saturate(INT64_MAX, &saturated);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, saturated);
}

static void test_q31_sums_saturate_and_count(void)
{
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, tribo_q31_add(INT32_MAX - 5, 5, &saturated));
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, tribo_q31_add(INT32_MIN + 5, -5, &saturated));
    TEST_ASSERT_EQUAL_INT32(-1, tribo_q31_add(INT32_MAX, INT32_MIN, &saturated));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, tribo_q31_subtract(INT32_MAX - 5, -5, &saturated));
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, tribo_q31_subtract(INT32_MIN + 5, 5, &saturated));
    TEST_ASSERT_EQUAL_INT32(0, tribo_q31_subtract(INT32_MIN, INT32_MIN, &saturated));
    TEST_ASSERT_EQUAL_UINT32(0, saturated);
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, tribo_q31_add(INT32_MAX - 5, 6, &saturated));
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, tribo_q31_add(INT32_MIN + 5, -6, &saturated));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, tribo_q31_subtract(0, INT32_MIN, &saturated));
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, tribo_q31_subtract(-2, INT32_MAX, &saturated));
    TEST_ASSERT_EQUAL_UINT32(4, saturated);
}

/// Both products where their halves of 16 bits are at their ends, as 64 bits have them.
static void test_q31_products_are_exact(void)
{
    static const uint32_t words[] = {0u,          1u,          2u,          0x7fffu,     0x8000u,
                                     0x8001u,     0xffffu,     0x10000u,    0x10001u,    0x7fffffffu,
                                     0x80000000u, 0x80000001u, 0x8000ffffu, 0xffff0000u, 0xffff0001u,
                                     0xffff8000u, 0xfffffffeu, 0xffffffffu, 0x5a82799au, 0xa57d8667u};
    const size_t          count   = sizeof words / sizeof words[0];
    for (size_t i = 0; i < count * count; i++)
    {
        const uint32_t a = words[i / count];
        const uint32_t b = words[i % count];
        TEST_ASSERT_EQUAL_UINT64((uint64_t)a * b, tribo_q31_product(a, b));
        TEST_ASSERT_EQUAL_INT64((int64_t)(int32_t)a * (int32_t)b, tribo_q31_multiply((int32_t)a, (int32_t)b));
    }
}

/// x / 2^shift rounded down, within 32 bits, as 64 bits have it.
static void check_narrow(int64_t x, uint32_t shift, uint32_t *expected)
{
    const int64_t part = x >> shift;
    const int64_t fit  = part > INT32_MAX ? INT32_MAX : (part < INT32_MIN ? INT32_MIN : part);
    *expected += fit != part;
    TEST_ASSERT_EQUAL_INT64(fit, tribo_q31_narrow(x, shift, &saturated));
    TEST_ASSERT_EQUAL_UINT32(*expected, saturated);
}

// At both ends of what fits, to the bit, and over all of 64 bits.
static void test_q31_narrows_as_64_bits_do(void)
{
    random_t r        = {21};
    uint32_t expected = 0;
    for (uint32_t shift = 1; shift <= 31u; shift++)
    {
        const int64_t one   = INT64_C(1) << shift;
        const int64_t above = one * ((int64_t)INT32_MAX + 1); // the first that does not fit
        const int64_t below = one * INT32_MIN;                // the last that does
        const int64_t x[]   = {0,
                               1,
                               -1,
                               one - 1,
                               one,
                               -one,
                               1 - one,
                               above - 1,
                               above,
                               above + 1,
                               above + above / 2,
                               below - 1,
                               below,
                               below + 1,
                               2 * below,
                               above + (above - one),
                               INT64_MAX,
                               INT64_MIN,
                               INT64_MIN + 1};
        for (size_t i = 0; i < sizeof x / sizeof x[0]; i++)
        {
            check_narrow(x[i], shift, &expected);
        }
        for (int k = 0; k < 1000; k++)
        {
            check_narrow((int64_t)random_bits(&r) >> (random_bits(&r) % 64u), shift, &expected);
        }
    }
    TEST_ASSERT_TRUE(expected > 2000u);
    saturated = UINT32_MAX;
    (void)tribo_q31_narrow(INT64_MAX, 28, &saturated);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, saturated);
}

static void test_q31_widens_to_the_end_of_its_range(void)
{
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, tribo_q31_widen(INT32_MIN, 0, &saturated));
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, tribo_q31_widen(-1, 31, &saturated));
    TEST_ASSERT_EQUAL_INT32(0x7ffffff8, tribo_q31_widen(0x0fffffff, 3, &saturated));
    TEST_ASSERT_EQUAL_UINT32(0, saturated);
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, tribo_q31_widen(0x10000000, 3, &saturated));
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, tribo_q31_widen(-0x10000001, 3, &saturated));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, tribo_q31_widen(2, 31, &saturated));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, tribo_q31_widen(INT32_MAX, 1, &saturated));
    TEST_ASSERT_EQUAL_UINT32(4, saturated);
}

static void test_q31_magnitude_fits_whatever_the_number(void)
{
    TEST_ASSERT_EQUAL_UINT32(0, tribo_q31_magnitude(0));
    TEST_ASSERT_EQUAL_UINT32(1, tribo_q31_magnitude(-1));
    TEST_ASSERT_EQUAL_UINT32(INT32_MAX, tribo_q31_magnitude(INT32_MAX));
    TEST_ASSERT_EQUAL_UINT32(INT32_MAX, tribo_q31_magnitude(-INT32_MAX));
    TEST_ASSERT_EQUAL_UINT32(UINT32_C(1) << 31, tribo_q31_magnitude(INT32_MIN));
}

static void test_q31_shift_to_zero_treats_both_signs_alike(void)
{
    for (uint32_t shift = 0; shift <= 31u; shift++)
    {
        const int64_t one = INT64_C(1) << shift;
        TEST_ASSERT_EQUAL_INT64(0, tribo_q31_shift_to_zero(1 - one, shift));
        TEST_ASSERT_EQUAL_INT64(0, tribo_q31_shift_to_zero(one - 1, shift));
        TEST_ASSERT_EQUAL_INT64(1, tribo_q31_shift_to_zero(one, shift));
        TEST_ASSERT_EQUAL_INT64(-1, tribo_q31_shift_to_zero(-one, shift));
        TEST_ASSERT_EQUAL_INT64(-(INT64_MAX / one), tribo_q31_shift_to_zero(-INT64_MAX, shift));
    }
}

static void test_q31_leading_zeros_of_every_length(void)
{
    for (uint32_t zeros = 0; zeros < 32u; zeros++)
    {
        TEST_ASSERT_EQUAL_UINT32(zeros, tribo_q31_leading_zeros(UINT32_C(0x80000000) >> zeros));
        TEST_ASSERT_EQUAL_UINT32(zeros, tribo_q31_leading_zeros(UINT32_MAX >> zeros));
    }
}

/// What the header promises: 2 in the last place, or 2^-29 of the result; never more than the quotient.
static void check_ratio(uint32_t a, uint32_t b)
{
    const double exact = (double)a / (double)b * 2147483648.0;
    const double found = (double)tribo_q31_ratio(a, b);
    TEST_ASSERT_TRUE(found <= exact && found <= 2147483647.0);
    TEST_ASSERT_DOUBLE_WITHIN(2.0 + exact * 0x1p-29, exact, found);
}

static void test_q31_ratio_is_as_close_as_its_header_says(void)
{
    const uint32_t ends[] = {1,
                             2,
                             3,
                             0x7fff,
                             0x8000,
                             0xffff,
                             0x10000,
                             0x10001,
                             0x7fffffff,
                             0x80000000,
                             0x80000001,
                             0x8000ffff,
                             0x80010000,
                             0xfffeffff,
                             0xffff0000,
                             0xffffffff};
    for (size_t i = 0; i < sizeof ends / sizeof ends[0]; i++)
    {
        for (size_t j = 0; j < sizeof ends / sizeof ends[0]; j++)
        {
            for (uint32_t shift = 0; shift < 32u; shift++)
            {
                if (ends[i] >> shift < ends[j])
                {
                    check_ratio(ends[i] >> shift, ends[j]);
                }
            }
        }
    }
    random_t r = {31};
    for (int i = 0; i < 100000; i++)
    {
        const uint32_t a = (uint32_t)(random_bits(&r) >> 32) >> (random_bits(&r) % 32u);
        const uint32_t b = (uint32_t)(random_bits(&r) >> 32) >> (random_bits(&r) % 32u);
        check_ratio(a % (b | 1u), b | 1u);
        check_ratio(b - (b > 0u), b | (b == 0u)); // almost 1
    }
}

static void test_q31_constants_are_in_parts_of_full_scale(void)
{
    TEST_ASSERT_EQUAL_INT32(INT32_MAX / 4, TRIBO_Q31(0.5, 2.0));
    TEST_ASSERT_EQUAL_INT32(-(INT32_MAX / 4), TRIBO_Q31(-0.5f, 2));
    TEST_ASSERT_EQUAL_INT32(0, TRIBO_Q31(0, 2.0));
}

#include "runners/test_q31.inc" // main
