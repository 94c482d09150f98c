// The histogram of times, and a priority that is refused.

#include "realtime.h"

#include "unity.h"

#include <string.h>

static void test_a_bin_ends_below_its_power_of_two(void)
{
    histogram_t histogram = {.total = 0};
    histogram_add(&histogram, 999);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, histogram_quantile_us(&histogram, 1.0));
    histogram_add(&histogram, 1000);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, histogram_quantile_us(&histogram, 0.5));
    TEST_ASSERT_EQUAL_DOUBLE(2.0, histogram_quantile_us(&histogram, 1.0));
    TEST_ASSERT_EQUAL_INT64(1000, histogram.longest_ns);
}

static void test_quantiles_are_those_of_what_was_added(void)
{
    histogram_t histogram = {.total = 0};
    TEST_ASSERT_EQUAL_DOUBLE(0.0, histogram_quantile_us(&histogram, 0.5));
    for (int i = 0; i < 99; i++)
    {
        histogram_add(&histogram, 3000);
    }
    histogram_add(&histogram, 60 * INT64_C(1000000));
    TEST_ASSERT_EQUAL_DOUBLE(4.0, histogram_quantile_us(&histogram, 0.5));
    TEST_ASSERT_EQUAL_DOUBLE(4.0, histogram_quantile_us(&histogram, 0.99));
    TEST_ASSERT_EQUAL_DOUBLE(65536.0, histogram_quantile_us(&histogram, 1.0));
}

static void test_no_time_is_too_long_or_before_zero(void)
{
    histogram_t histogram = {.total = 0};
    histogram_add(&histogram, INT64_MAX);
    histogram_add(&histogram, -5);
    TEST_ASSERT_EQUAL_UINT64(1, histogram.count[HISTOGRAM_BINS - 1u]);
    TEST_ASSERT_EQUAL_UINT64(1, histogram.count[0]);
    TEST_ASSERT_EQUAL_UINT64(2, histogram.total);
}

static void test_a_sleep_ends_when_it_is_due(void)
{
    const int64_t due_ns = realtime_now_ns() + 3000000;
    TEST_ASSERT_TRUE(realtime_sleep_until(due_ns));
    TEST_ASSERT_TRUE(realtime_now_ns() >= due_ns);
    TEST_ASSERT_TRUE(realtime_sleep_until(due_ns)); // over: at once
}

static void test_a_missing_cpu_is_refused_with_its_key(void)
{
    common_error_t          error  = {""};
    const realtime_config_t config = {.priority = 1, .cpu = 1 << 20};
    TEST_ASSERT_FALSE(realtime_enter(&config, &error));
    TEST_ASSERT_EQUAL_STRING_LEN("realtime.cpu: value 1048576: must be a CPU that this process may run on",
                                 error.text,
                                 strlen("realtime.cpu: value 1048576: must be a CPU that this process may run on"));
}

#include "runners/test_realtime.inc" // main
