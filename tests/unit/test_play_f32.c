#include "tribo/play_f32.h"

#include "same.h"
#include "unity.h"

#include <math.h>

static tribo_play_f32_state_t play;

void setUp(void)
{
    tribo_play_f32_reset(&play, 1.0f);
}

void tearDown(void)
{
}

static void test_play_stands_while_the_input_stays_between_its_stops(void)
{
    TEST_ASSERT_SAME_FLOAT(0.0f, tribo_play_f32_step(&play, 1.25f, 0.25f, 0.5f));
    TEST_ASSERT_SAME_FLOAT(0.0f, tribo_play_f32_step(&play, 0.5f, 0.25f, 0.5f));
    TEST_ASSERT_SAME_FLOAT(1.0f, play.position_n);
    TEST_ASSERT_EQUAL_INT32(0, play.way);
}

static void test_play_is_dragged_along_at_the_distance_of_the_stop_that_it_meets(void)
{
    TEST_ASSERT_SAME_FLOAT(0.75f, tribo_play_f32_step(&play, 2.0f, 0.25f, 0.5f));
    TEST_ASSERT_SAME_FLOAT(1.75f, play.position_n);
    TEST_ASSERT_EQUAL_INT32(1, play.way);
    TEST_ASSERT_SAME_FLOAT(-0.25f, tribo_play_f32_step(&play, 1.0f, 0.25f, 0.5f));
    TEST_ASSERT_SAME_FLOAT(1.5f, play.position_n);
    TEST_ASSERT_EQUAL_INT32(-1, play.way);
}

static void test_play_remembers_its_way_where_it_stands(void)
{
    (void)tribo_play_f32_step(&play, 2.0f, 0.25f, 0.25f);
    for (int k = 0; k < 10; k++)
    {
        TEST_ASSERT_SAME_FLOAT(0.0f, tribo_play_f32_step(&play, 1.5f + 0.05f * (float)k, 0.25f, 0.25f));
        TEST_ASSERT_EQUAL_INT32(1, play.way);
    }
}

static void test_play_turns_when_the_input_has_come_back_by_both_distances(void)
{
    (void)tribo_play_f32_step(&play, 2.0f, 0.25f, 0.5f);
    (void)tribo_play_f32_step(&play, 1.25f, 0.25f, 0.5f);
    TEST_ASSERT_EQUAL_INT32(1, play.way);
    (void)tribo_play_f32_step(&play, 1.24f, 0.25f, 0.5f);
    TEST_ASSERT_EQUAL_INT32(-1, play.way);
}

static void test_play_does_not_move_for_a_bad_input(void)
{
    const float bad[] = {NAN, INFINITY, -INFINITY, 1.1e6f, -1.1e6f};
    for (int i = 0; i < 5; i++)
    {
        TEST_ASSERT_SAME_FLOAT(0.0f, tribo_play_f32_step(&play, bad[i], 0.0f, 0.0f));
        TEST_ASSERT_SAME_FLOAT(0.0f, tribo_play_f32_step(&play, 5.0f, bad[i], 0.0f));
        TEST_ASSERT_SAME_FLOAT(0.0f, tribo_play_f32_step(&play, 5.0f, 0.0f, bad[i]));
    }
    TEST_ASSERT_SAME_FLOAT(0.0f, tribo_play_f32_step(&play, 5.0f, -0.1f, 0.0f));
    TEST_ASSERT_SAME_FLOAT(0.0f, tribo_play_f32_step(&play, 5.0f, 0.0f, -0.1f));
    TEST_ASSERT_SAME_FLOAT(1.0f, play.position_n);
    TEST_ASSERT_SAME_FLOAT(4.0f, tribo_play_f32_step(&play, 5.0f, 0.0f, 0.0f));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_play_stands_while_the_input_stays_between_its_stops);
    RUN_TEST(test_play_is_dragged_along_at_the_distance_of_the_stop_that_it_meets);
    RUN_TEST(test_play_remembers_its_way_where_it_stands);
    RUN_TEST(test_play_turns_when_the_input_has_come_back_by_both_distances);
    RUN_TEST(test_play_does_not_move_for_a_bad_input);
    return UNITY_END();
}
