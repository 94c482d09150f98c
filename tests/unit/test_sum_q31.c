// In the instructions of the target, and in what C makes of it elsewhere.

#include "sum_q31.h"

#include "random.h"
#include "unity.h"

#define ROUNDS 5000

void setUp(void)
{
}

void tearDown(void)
{
}

static sum_q31_t sum_of(uint64_t x)
{
    return sum_q31_of((uint32_t)x, (uint32_t)(x >> 32));
}

static uint64_t value(sum_q31_t sum)
{
    return (uint64_t)sum_q31_high(sum) << 32 | sum_q31_low(sum);
}

/// Of all sizes, and every fifth an end.
static uint64_t random_word(random_t *r)
{
    const uint64_t ends[] = {0, 1, UINT64_MAX, UINT64_C(1) << 63, (UINT64_C(1) << 63) - 1u, UINT64_C(0xffffffff)};
    return random_bits(r) % 5u == 0u ? ends[random_bits(r) % 6u] : random_bits(r) >> random_bits(r) % 60u;
}

static int32_t random_factor(random_t *r)
{
    const int32_t ends[] = {0, 1, -1, INT32_MAX, INT32_MIN, INT32_C(1) << 16};
    return random_bits(r) % 5u == 0u ? ends[random_bits(r) % 6u] : (int32_t)(uint32_t)random_bits(r);
}

static void test_sum_adds_products_and_words_and_wraps(void)
{
    random_t      r   = {1};
    const int32_t one = sum_q31_one();
    TEST_ASSERT_EQUAL_INT32(1, one);
    for (int k = 0; k < ROUNDS; k++)
    {
        const uint64_t x = random_word(&r);
        const int32_t  a = random_factor(&r);
        const int32_t  b = random_factor(&r);
        TEST_ASSERT_EQUAL_HEX64(x + (uint64_t)((int64_t)a * b), value(sum_q31_accumulate(sum_of(x), a, b)));
        TEST_ASSERT_EQUAL_HEX64(x + (uint32_t)a, value(sum_q31_add(sum_of(x), (uint32_t)a, one)));
        TEST_ASSERT_EQUAL_HEX64(x + (uint64_t)(int64_t)a, value(sum_q31_add_signed(sum_of(x), a, one)));
        TEST_ASSERT_EQUAL_HEX64(x, value(sum_q31_settle(sum_of(x))));
    }
}

static void test_sum_adds_what_is_shifted_to_the_last_bit(void)
{
    random_t      r      = {11};
    const int64_t ends[] = {(INT64_C(1) << 61) - 1, -(INT64_C(1) << 61), 0, -1, 1};
    for (uint32_t shift = 0; shift <= 30u; shift++)
    {
        const int32_t power = INT32_C(1) << (30u - shift);
        for (uint32_t k = 0; k < 2000u; k++)
        {
            const int64_t  x = k < 5u ? ends[k] : (int64_t)random_bits(&r) >> (3u + k % 50u);
            const uint64_t y = random_bits(&r);
            TEST_ASSERT_EQUAL_HEX64(y + (uint64_t)(x >> shift),
                                    value(sum_q31_add_shifted(sum_of(y),
                                                              sum_of((uint64_t)x),
                                                              (pair_t){power, (int32_t)(shift | 0x7f00u)},
                                                              sum_q31_one())));
        }
    }
}

// Beside what stands there, and after it was written as a number.
static void test_sum_is_read_and_written_whole(void)
{
    random_t r = {3};
    for (int k = 0; k < ROUNDS; k++)
    {
        int64_t        at[3] = {-2, (int64_t)random_word(&r), -3};
        const uint64_t x     = random_word(&r);
        TEST_ASSERT_EQUAL_HEX64((uint64_t)at[1], value(sum_q31_load(&at[1])));
        sum_q31_store(&at[1], sum_of(x));
        TEST_ASSERT_EQUAL_INT64(-2, at[0]);
        TEST_ASSERT_EQUAL_HEX64(x, (uint64_t)at[1]);
        TEST_ASSERT_EQUAL_INT64(-3, at[2]);

        int32_t words[4]        = {1, random_factor(&r), random_factor(&r), 4};
        words[k % 4]            = random_factor(&r);
        const pair_t words_at_1 = pair_load(&words[1]);
        TEST_ASSERT_EQUAL_INT32(words[1], words_at_1.first);
        TEST_ASSERT_EQUAL_INT32(words[2], words_at_1.second);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_sum_adds_products_and_words_and_wraps);
    RUN_TEST(test_sum_adds_what_is_shifted_to_the_last_bit);
    RUN_TEST(test_sum_is_read_and_written_whole);
    return UNITY_END();
}
