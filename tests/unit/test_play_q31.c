#include "tribo/play_q31.h"

#include "unity.h"

#define MOST (INT32_C(1) << 30)

static tribo_play_q31_state_t play;

void setUp(void)
{
    tribo_play_q31_reset(&play, 1000);
}

void tearDown(void)
{
}

static void test_play_stands_between_its_stops_and_is_dragged_along_beyond(void)
{
    TEST_ASSERT_EQUAL_INT32(0, tribo_play_q31_step(&play, 1250, 250, 500));
    TEST_ASSERT_EQUAL_INT32(0, tribo_play_q31_step(&play, 500, 250, 500));
    TEST_ASSERT_EQUAL_INT32(0, play.way);
    TEST_ASSERT_EQUAL_INT32(1, tribo_play_q31_step(&play, 1251, 250, 500));
    TEST_ASSERT_EQUAL_INT32(1, play.way);
    TEST_ASSERT_EQUAL_INT32(-2, tribo_play_q31_step(&play, 499, 250, 500));
    TEST_ASSERT_EQUAL_INT32(999, play.position);
    TEST_ASSERT_EQUAL_INT32(-1, play.way);
    TEST_ASSERT_EQUAL_INT32(0, tribo_play_q31_step(&play, 1249, 250, 500));
    TEST_ASSERT_EQUAL_INT32(-1, play.way);
}

static void test_play_takes_what_is_beyond_for_the_nearest_that_is_not(void)
{
    TEST_ASSERT_EQUAL_INT32(MOST - 1000, tribo_play_q31_step(&play, INT32_MAX, 0, 0));
    TEST_ASSERT_EQUAL_INT32(-2 * MOST, tribo_play_q31_step(&play, INT32_MIN, 0, 0));
    TEST_ASSERT_EQUAL_INT32(-MOST, play.position);
    TEST_ASSERT_EQUAL_INT32(0, tribo_play_q31_step(&play, 0, INT32_MAX, 0));
    TEST_ASSERT_EQUAL_INT32(MOST, tribo_play_q31_step(&play, 0, INT32_MIN, -1));
    TEST_ASSERT_EQUAL_INT32(0, tribo_play_q31_step(&play, -MOST, 0, INT32_MAX));
    tribo_play_q31_reset(&play, INT32_MIN);
    TEST_ASSERT_EQUAL_INT32(-MOST, play.position);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_play_stands_between_its_stops_and_is_dragged_along_beyond);
    RUN_TEST(test_play_takes_what_is_beyond_for_the_nearest_that_is_not);
    return UNITY_END();
}
