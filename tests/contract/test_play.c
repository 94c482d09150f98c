#include PARTS_HEADER
#include "unity.h"

static play_t play;

void setUp(void)
{
    play_reset(&play, 1.0);
}

static void check(double input, double half, double position, int32_t sign)
{
    play_step(&play, input, half);
    TEST_ASSERT_TRUE(play_position(&play) == position);
    TEST_ASSERT_EQUAL_INT32(sign, play.state.sign);
}

static void test_play_stands_while_the_input_stays_between_its_stops(void)
{
    check(1.25, 0.25, 1.0, 0);
    check(0.75, 0.25, 1.0, 0);
}

static void test_play_is_dragged_along_at_the_distance_of_the_stop_that_it_meets(void)
{
    check(1.25 + 0x1p-20, 0.25, 1.0 + 0x1p-20, 1);
    check(2.0, 0.25, 1.75, 1);
    check(1.0, 0.25, 1.25, -1);
    check(1.5, 0.25, 1.25, -1);
}

static void test_play_remembers_its_sign_where_it_stands(void)
{
    play_step(&play, 2.0, 0.25);
    for (int k = 0; k < 10; k++)
    {
        check(1.5 + 0.05 * k, 0.25, 1.75, 1);
    }
}

static void test_play_turns_when_the_input_has_come_back_by_twice_the_distance(void)
{
    check(2.0, 0.25, 1.75, 1);
    check(1.5, 0.25, 1.75, 1);
    check(1.5 - 0x1p-7, 0.25, 1.75 - 0x1p-7, -1);
}

static void test_play_without_a_width_follows(void)
{
    check(2.0, 0.0, 2.0, 1);
    check(-2.0, 0.0, -2.0, -1);
    play_reset(&play, 0.5);
    TEST_ASSERT_EQUAL_INT32(0, play.state.sign);
    TEST_ASSERT_TRUE(play_position(&play) == 0.5);
}

#include "runners/test_play.inc" // main
