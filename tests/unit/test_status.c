#include "tribo/status.h"
#include "unity.h"

#include <string.h>

static void test_every_status_names_its_field_and_range_once(void)
{
    for (int i = TRIBO_OK; i < TRIBO_STATUS_COUNT; i++)
    {
        const char *text = tribo_status_text((tribo_status_t)i);
        TEST_ASSERT_NOT_NULL(text);
        TEST_ASSERT_TRUE_MESSAGE(i == TRIBO_OK || strchr(text, ':') != NULL, text);
        for (int j = TRIBO_OK; j < i; j++)
        {
            TEST_ASSERT_TRUE_MESSAGE(strcmp(text, tribo_status_text((tribo_status_t)j)) != 0, text);
        }
    }
    TEST_ASSERT_EQUAL_STRING("no error", tribo_status_text(TRIBO_OK));
    TEST_ASSERT_EQUAL_STRING("sample_time_s: 1e-6 to 0.1 s", tribo_status_text(TRIBO_ERR_SAMPLE_TIME));
    TEST_ASSERT_EQUAL_STRING("full_scale_n: 1e-3 to 1e6 N", tribo_status_text(TRIBO_ERR_FULL_SCALE));
}

static void test_a_text_has_the_unit_and_the_condition_where_there_are_any(void)
{
    TEST_ASSERT_EQUAL_STRING("friction m: 0 to 100", tribo_status_text(TRIBO_ERR_M));
    TEST_ASSERT_EQUAL_STRING("friction k_min: 1.01 to 1000; at most k_max", tribo_status_text(TRIBO_ERR_K_MIN));
    TEST_ASSERT_EQUAL_STRING("friction v0_n_per_s: 1e-6 to 1e6 N/s; q31: over m full_scale_n/(6 2^31 h)",
                             tribo_status_text(TRIBO_ERR_V0));
}

static void test_a_text_says_which_direction(void)
{
    TEST_ASSERT_EQUAL_STRING("friction breakaway positive.slope: 0 to 10",
                             tribo_status_text(TRIBO_ERR_BREAKAWAY_SLOPE));
    TEST_ASSERT_EQUAL_STRING("friction breakaway negative.slope: 0 to 10",
                             tribo_status_text(TRIBO_ERR_BREAKAWAY_NEGATIVE_SLOPE));
}

static void test_an_unknown_status_has_a_text_too(void)
{
    TEST_ASSERT_EQUAL_STRING("unknown status", tribo_status_text(TRIBO_STATUS_COUNT));
}

#include "runners/test_status.inc" // main
