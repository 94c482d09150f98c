#include PARTS_HEADER
#include "unity.h"

static play_t play;

void setUp(void)
{
    play_reset(&play, 1.0);
}

void tearDown(void)
{
}

static void check(double moved, double input, double position, int32_t sign)
{
    TEST_ASSERT_TRUE(play_step(&play, input, 0.25, 0.5) == moved);
    TEST_ASSERT_TRUE(play_position(&play) == position);
    TEST_ASSERT_EQUAL_INT32(sign, play.state.sign);
}

static void test_play_stands_while_the_input_stays_between_its_stops(void)
{
    check(0.0, 1.25, 1.0, 0);
    check(0.0, 0.5, 1.0, 0);
}

static void test_play_is_dragged_along_at_the_distance_of_the_stop_that_it_meets(void)
{
    check(0x1p-20, 1.25 + 0x1p-20, 1.0 + 0x1p-20, 1);
    check(0.75 - 0x1p-20, 2.0, 1.75, 1);
    check(-0.25, 1.0, 1.5, -1);
    check(0.0, 1.75, 1.5, -1);
}

static void test_play_remembers_its_sign_where_it_stands(void)
{
    (void)play_step(&play, 2.0, 0.25, 0.25);
    for (int k = 0; k < 10; k++)
    {
        TEST_ASSERT_TRUE(play_step(&play, 1.5 + 0.05 * k, 0.25, 0.25) == 0.0);
        TEST_ASSERT_EQUAL_INT32(1, play.state.sign);
    }
}

static void test_play_turns_when_the_input_has_come_back_by_both_distances(void)
{
    check(0.75, 2.0, 1.75, 1);
    check(0.0, 1.25, 1.75, 1);
    check(-0x1p-7, 1.25 - 0x1p-7, 1.75 - 0x1p-7, -1);
}

static void test_play_without_a_width_follows(void)
{
    TEST_ASSERT_TRUE(play_step(&play, 2.0, 0.0, 0.0) == 1.0);
    TEST_ASSERT_TRUE(play_step(&play, -2.0, 0.0, 0.0) == -4.0);
    play_reset(&play, 0.5);
    TEST_ASSERT_EQUAL_INT32(0, play.state.sign);
    TEST_ASSERT_TRUE(play_position(&play) == 0.5);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_play_stands_while_the_input_stays_between_its_stops);
    RUN_TEST(test_play_is_dragged_along_at_the_distance_of_the_stop_that_it_meets);
    RUN_TEST(test_play_remembers_its_sign_where_it_stands);
    RUN_TEST(test_play_turns_when_the_input_has_come_back_by_both_distances);
    RUN_TEST(test_play_without_a_width_follows);
    return UNITY_END();
}
