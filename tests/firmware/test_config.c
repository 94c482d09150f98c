// The drive's config: every field has a range, and the first that is out of it is named.

#include "app/config.h"
#include "unity.h"

#include <math.h>
#include <string.h>

static drive_config_t       config;
static drive_config_error_t error;

void setUp(void)
{
    config = drive_config_default();
    error  = (drive_config_error_t){0};
}

static void check_refused(const char *field, float value, float low, float high)
{
    TEST_ASSERT_FALSE_MESSAGE(drive_config_check(&config, &error), field);
    TEST_ASSERT_EQUAL_STRING(field, drive_config_name(error.field));
    TEST_ASSERT_TRUE_MESSAGE(error.value == value, field);
    TEST_ASSERT_TRUE_MESSAGE(error.low == low && error.high == high, field);
}

static void test_the_defaults_are_within_their_ranges(void)
{
    TEST_ASSERT_TRUE(drive_config_check(&config, &error));
}

/// A value that the type can hold, out of the range from below, or above.
#define BELOW(low)  ((low) > 1 ? (double)(low) / 2 : -1.0 + (double)(low))
#define ABOVE(high) (2.0 * (double)(high) + 1.0)

static void test_every_field_is_refused_beyond_its_range_and_named(void)
{
    const drive_config_t normal = config;
#define CHECK(type, name, unit, low, high, zero_ok, value, change, text)                                               \
    config.name = (type)ABOVE(high);                                                                                   \
    check_refused(#name, (float)config.name, (float)(low), (float)(high));                                             \
    TEST_ASSERT_EQUAL_INT((zero_ok), error.off);                                                                       \
    if ((type)0.5 != 0 || (low) > 1) /* a whole number has nothing below 0 */                                          \
    {                                                                                                                  \
        config.name = (type)BELOW(low);                                                                                \
        check_refused(#name, (float)config.name, (float)(low), (float)(high));                                         \
    }                                                                                                                  \
    config = normal;
    DRIVE_CONFIG_FIELDS(CHECK)
#undef CHECK
}

static void test_zero_turns_off_only_what_can_be_off(void)
{
    const drive_config_t normal = config;
#define CHECK(type, name, unit, low, high, zero_ok, value, change, text)                                               \
    config.name = 0;                                                                                                   \
    TEST_ASSERT_EQUAL_INT_MESSAGE((zero_ok) != 0 || (low) <= 0, drive_config_check(&config, &error), #name);           \
    config = normal;
    DRIVE_CONFIG_FIELDS(CHECK)
#undef CHECK
}

static void test_a_nan_is_refused_wherever_it_is(void)
{
    const drive_config_t normal = config;
#define CHECK(type, name, unit, low, high, zero_ok, value, change, text)                                               \
    if ((type)0.5 != 0)                                                                                                \
    {                                                                                                                  \
        const float nan = NAN;                                                                                         \
        memcpy(&config.name, &nan, sizeof nan);                                                                        \
        TEST_ASSERT_FALSE_MESSAGE(drive_config_check(&config, &error), #name);                                         \
        TEST_ASSERT_EQUAL_STRING(#name, drive_config_name(error.field));                                               \
        config = normal;                                                                                               \
    }
    DRIVE_CONFIG_FIELDS(CHECK)
#undef CHECK
}

static void test_jitter_and_budget_fit_the_period(void)
{
    config.late_us = config.period_us;
    check_refused("late_us", 1000.0f, 0.0f, 999.0f);
    config.late_us   = config.period_us - 1u;
    config.budget_us = config.period_us;
    TEST_ASSERT_TRUE(drive_config_check(&config, &error));
    config.budget_us++;
    check_refused("budget_us", 1001.0f, 1.0f, 1000.0f);
}

#include "runners/test_config.inc" // main
