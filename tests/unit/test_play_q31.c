// What only the Q31 arithmetic has. What both promise: tests/contract/test_play.c.

#include "loop/guard_q31.h"

#include "unity.h"

#define MOST (INT32_C(1) << 30)

static void test_play_moves_over_the_whole_range(void)
{
    tribo_play_q31_state_t play;
    guard_play_reset(&play, 1000);
    guard_play_step(&play, MOST, 0);
    TEST_ASSERT_EQUAL_INT32(MOST, play.position);
    guard_play_step(&play, 0, MOST);
    TEST_ASSERT_EQUAL_INT32(MOST, play.position);
    guard_play_step(&play, -MOST, 0);
    TEST_ASSERT_EQUAL_INT32(-MOST, play.position);
    guard_play_step(&play, 0, MOST);
    TEST_ASSERT_EQUAL_INT32(-MOST, play.position);
    TEST_ASSERT_EQUAL_INT32(-1, play.sign);
}

static void test_play_starts_within_the_range(void)
{
    tribo_play_q31_state_t play;
    guard_play_reset(&play, INT32_MIN);
    TEST_ASSERT_EQUAL_INT32(-MOST, play.position);
    guard_play_reset(&play, INT32_MAX);
    TEST_ASSERT_EQUAL_INT32(MOST, play.position);
    TEST_ASSERT_EQUAL_INT32(0, play.sign);
}

#include "runners/test_play_q31.inc" // main
