#include "tribo/guard_f32.h"

#include "random.h"
#include "same.h"
#include "unity.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#define H 1.0e-3f

static tribo_guard_f32_config_t config;
static tribo_guard_f32_params_t params;
static tribo_guard_f32_state_t  guard;

void setUp(void)
{
    config = tribo_guard_f32_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_guard_f32_init(&params, &config, H));
    tribo_guard_f32_reset(&guard);
}

void tearDown(void)
{
}

/// `swings` in which f goes from one side to the other in `ticks`, and y with it by `swing_n` against `asked_n` of r.
static void swing(int swings, int ticks, float swing_n, float asked_n)
{
    for (int i = 0; i < swings; i++)
    {
        const float way = i % 2 == 0 ? 1.0f : -1.0f;
        for (int k = 1; k <= ticks; k++)
        {
            const float part = (float)k / (float)ticks - 0.5f;
            (void)tribo_guard_f32_step(&params,
                                       &guard,
                                       0.5f + way * asked_n * part,
                                       0.5f + way * swing_n * part,
                                       way * 0.1f);
        }
    }
}

static void test_sixteen_quick_turns_that_drive_the_force_are_hunting(void)
{
    swing(17, 100, 0.02f, 0.0f); // the first only begins
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.cause);
    TEST_ASSERT_EQUAL_UINT8(15, guard.turns);
    TEST_ASSERT_SAME_FLOAT(1.0f, guard.share);
    swing(1, 1, 0.02f, 0.0f); // the play has to turn
    (void)tribo_guard_f32_step(&params, &guard, 0.5f, 0.5f, -0.1f);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.cause);
}

static void test_slow_turns_are_no_hunting(void)
{
    swing(100, 202, 0.02f, 0.0f);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.cause);
    swing(20, 200, 0.02f, 0.0f);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.cause);
}

static void test_turns_that_the_reference_asks_for_are_no_hunting(void)
{
    swing(100, 100, 0.02f, 0.0077f); // W 4.6e-4, asked 5e-4
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.cause);
    swing(20, 100, 0.02f, 0.0071f);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.cause);
}

static void test_turns_of_a_force_that_goes_the_other_way_are_no_hunting(void)
{
    swing(100, 100, -0.005f, 0.0f);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.cause);
}

static void test_one_slow_turn_forgives(void)
{
    for (int i = 0; i < 10; i++)
    {
        swing(14, 50, 0.02f, 0.0f);
        swing(2, 300, 0.02f, 0.0f);
    }
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.cause);
}

static void test_friction_that_turns_by_less_than_its_width_does_not_turn(void)
{
    for (int k = 0; k < 10000; k++)
    {
        const float way = k % 20 < 10 ? 1.0f : -1.0f;
        (void)tribo_guard_f32_step(&params, &guard, 0.5f, 0.5f + 0.001f * way * (float)(k % 10), way * 0.0249f);
    }
    TEST_ASSERT_EQUAL_UINT8(0, guard.turns);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.cause);
}

/// `reversals`, each of 1 s; the largest error is `wrong_n` beyond r the way of f, and `right_n` behind it.
static void reverse(int reversals, float wrong_n, float right_n)
{
    for (int i = 0; i < reversals; i++)
    {
        const float way = i % 2 == 0 ? 1.0f : -1.0f;
        for (int k = 0; k < 1000; k++)
        {
            const float e = k == 300 ? -wrong_n : k == 600 ? right_n : 0.0f;
            (void)tribo_guard_f32_step(&params, &guard, 0.5f, 0.5f - way * e, way * 0.1f);
        }
    }
}

static void test_four_breakaways_with_the_wrong_error_are_overshoot(void)
{
    reverse(5, 0.0141f, 0.004f); // the first only begins, the last has not ended
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.cause);
    TEST_ASSERT_EQUAL_UINT8(3, guard.strays);
    (void)tribo_guard_f32_step(&params, &guard, 0.5f, 0.5f, -0.1f);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_OVERSHOOT, guard.cause);
}

static void test_breakaways_with_the_right_error_or_little_of_the_wrong_one_are_not(void)
{
    reverse(50, 0.0139f, 0.004f);
    reverse(50, 0.0f, 0.2f);
    TEST_ASSERT_EQUAL_UINT8(0, guard.strays);
    for (int i = 0; i < 10; i++)
    {
        reverse(2, 0.1f, 0.0f);
        reverse(2, 0.0f, 0.1f);
    }
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.cause);
}

static void test_the_share_fades_in_half_a_second_and_stays_at_nothing(void)
{
    swing(40, 20, 0.02f, 0.0f);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.cause);
    tribo_guard_f32_reset(&guard);
    guard.cause  = TRIBO_GUARD_HUNTING;
    float before = 1.0f;
    for (int k = 1; k <= 501; k++)
    {
        const float share = tribo_guard_f32_step(&params, &guard, 0.5f, 0.5f, 0.0f);
        TEST_ASSERT_TRUE(share < before && before - share < 0.00201f);
        before = share;
        if (share == 0.0f)
        {
            TEST_ASSERT_INT_WITHIN(1, 500, k);
            break;
        }
    }
    TEST_ASSERT_SAME_FLOAT(0.0f, before);
    reverse(20, 0.1f, 0.0f); // another cause does not replace the first
    TEST_ASSERT_SAME_FLOAT(0.0f, guard.share);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.cause);
}

static void test_a_guard_that_is_restored_lets_friction_back_and_judges_anew(void)
{
    guard.cause  = TRIBO_GUARD_OVERSHOOT;
    guard.share  = 0.0f;
    guard.turns  = 16;
    guard.strays = 4;
    tribo_guard_f32_restore(&guard);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.cause);
    TEST_ASSERT_SAME_FLOAT(0.002f, tribo_guard_f32_step(&params, &guard, 0.5f, 0.5f, 0.1f));
    swing(10, 100, 0.02f, 0.0f);
    TEST_ASSERT_SAME_FLOAT(1.0f, guard.share);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.cause);
    swing(12, 100, 0.02f, 0.0f);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.cause);
}

static void test_bad_inputs_are_not_judged(void)
{
    const float bad[] = {NAN, INFINITY, -INFINITY, 1.1e6f, -1.1e6f};
    swing(10, 100, 0.02f, 0.0f);
    for (int i = 0; i < 5; i++)
    {
        tribo_guard_f32_state_t before = guard;
        TEST_ASSERT_SAME_FLOAT(1.0f, tribo_guard_f32_step(&params, &guard, bad[i], 0.5f, -0.1f));
        TEST_ASSERT_SAME_FLOAT(1.0f, tribo_guard_f32_step(&params, &guard, 0.5f, bad[i], -0.1f));
        TEST_ASSERT_SAME_FLOAT(1.0f, tribo_guard_f32_step(&params, &guard, 0.5f, 0.5f, bad[i]));
        TEST_ASSERT_EQUAL_MEMORY(&before, &guard, sizeof guard);
    }
}

static void test_whatever_the_signals_the_share_is_within_0_and_1(void)
{
    random_t r = {5};
    for (int k = 0; k < 200000; k++)
    {
        const float scale = k % 1000 < 500 ? 1.0f : 1.0e6f;
        const float x     = (float)random_between(&r, -1.1, 1.1) * scale;
        const float share = tribo_guard_f32_step(&params, &guard, (float)random_between(&r, -1.0, 1.0), x, -x);
        TEST_ASSERT_TRUE(share >= 0.0f && share <= 1.0f);
        if (k % 5000 == 0)
        {
            tribo_guard_f32_restore(&guard);
        }
    }
}

static void test_a_corrupt_state_recovers(void)
{
    swing(4, 100, 0.02f, 0.0f);
    guard.play.position_n = NAN;
    guard.work_n2         = NAN;
    guard.high_n          = NAN;
    guard.y_n             = NAN;
    guard.share           = NAN;
    swing(20, 100, 0.02f, 0.0f);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.cause);
    TEST_ASSERT_TRUE(guard.share >= 0.0f && guard.share < 1.0f);
}

static void check(float *field, float bad, tribo_status_t expected)
{
    const float                    good = *field;
    const tribo_guard_f32_params_t was  = params;
    *field                              = bad;
    TEST_ASSERT_EQUAL_INT(expected, tribo_guard_f32_init(&params, &config, H));
    *field = NAN;
    TEST_ASSERT_EQUAL_INT(expected, tribo_guard_f32_init(&params, &config, H));
    TEST_ASSERT_EQUAL_MEMORY(&was, &params, sizeof params);
    *field = good;
}

static void test_set_up_names_the_field_that_is_wrong(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_guard_f32_init(NULL, &config, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_guard_f32_init(&params, NULL, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SAMPLE_TIME, tribo_guard_f32_init(&params, &config, 0.2f));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SAMPLE_TIME, tribo_guard_f32_init(&params, &config, NAN));
    check(&config.turn_n, 0.0f, TRIBO_ERR_GUARD_TURN);
    check(&config.turn_n, 2.0e6f, TRIBO_ERR_GUARD_TURN);
    check(&config.quick_time_s, 0.0f, TRIBO_ERR_GUARD_TIME);
    check(&config.quick_time_s, 101.0f, TRIBO_ERR_GUARD_TIME); // 1e5 samples
    check(&config.fade_time_s, 0.0f, TRIBO_ERR_GUARD_TIME);
    check(&config.fade_time_s, 2.0e3f, TRIBO_ERR_GUARD_TIME);
    check(&config.stray_n, 0.0f, TRIBO_ERR_GUARD_STRAY);
    check(&config.stray_n, 2.0e6f, TRIBO_ERR_GUARD_STRAY);
    config.quick_time_s = 2000.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_GUARD_TIME, tribo_guard_f32_init(&params, &config, 0.1f));
    config             = tribo_guard_f32_default();
    config.fade_time_s = 1.0e-6f; // at once
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_guard_f32_init(&params, &config, H));
    guard.cause = TRIBO_GUARD_HUNTING;
    TEST_ASSERT_SAME_FLOAT(0.0f, tribo_guard_f32_step(&params, &guard, 0.5f, 0.5f, 0.1f));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_sixteen_quick_turns_that_drive_the_force_are_hunting);
    RUN_TEST(test_slow_turns_are_no_hunting);
    RUN_TEST(test_turns_that_the_reference_asks_for_are_no_hunting);
    RUN_TEST(test_turns_of_a_force_that_goes_the_other_way_are_no_hunting);
    RUN_TEST(test_one_slow_turn_forgives);
    RUN_TEST(test_friction_that_turns_by_less_than_its_width_does_not_turn);
    RUN_TEST(test_four_breakaways_with_the_wrong_error_are_overshoot);
    RUN_TEST(test_breakaways_with_the_right_error_or_little_of_the_wrong_one_are_not);
    RUN_TEST(test_the_share_fades_in_half_a_second_and_stays_at_nothing);
    RUN_TEST(test_a_guard_that_is_restored_lets_friction_back_and_judges_anew);
    RUN_TEST(test_bad_inputs_are_not_judged);
    RUN_TEST(test_whatever_the_signals_the_share_is_within_0_and_1);
    RUN_TEST(test_a_corrupt_state_recovers);
    RUN_TEST(test_set_up_names_the_field_that_is_wrong);
    return UNITY_END();
}
