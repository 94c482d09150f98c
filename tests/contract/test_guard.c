#include PARTS_HEADER
#include "random.h"
#include "unity.h"

#include <math.h>
#include <stddef.h>

#define H 1e-3

static tribo_guard_f32_config_t config;
static guard_t                  guard;

void setUp(void)
{
    config = tribo_guard_f32_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, guard_init(&guard, &config, H));
}

/// `swings` in which f goes from one side to the other in `ticks`, and y with it by `swing_n` against `asked_n` of r.
static void swing(int swings, int ticks, double swing_n, double asked_n)
{
    for (int i = 0; i < swings; i++)
    {
        const double sign = i % 2 == 0 ? 1.0 : -1.0;
        for (int k = 1; k <= ticks; k++)
        {
            const double part = (double)k / ticks - 0.5;
            (void)guard_step(&guard, 0.5 + sign * asked_n * part, 0.5 + sign * swing_n * part, sign * 0.1);
        }
    }
}

static void test_sixteen_quick_turns_that_drive_the_force_are_hunting(void)
{
    swing(17, 100, 0.02, 0.0); // the first only begins
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.state.cause);
    TEST_ASSERT_EQUAL_UINT8(15, guard.state.turns);
    TEST_ASSERT_TRUE(guard_step(&guard, 0.5, 0.51, 0.1) == 1.0);
    swing(1, 1, 0.02, 0.0); // the play has to turn
    (void)guard_step(&guard, 0.5, 0.5, -0.1);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.state.cause);
}

static void test_slow_turns_are_not_hunting(void)
{
    swing(100, 202, 0.02, 0.0);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.state.cause);
    swing(20, 200, 0.02, 0.0);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.state.cause);
}

static void test_turns_that_follow_the_reference_are_not_hunting(void)
{
    swing(100, 100, 0.02, 0.0077); // W 4.6e-4, asked 5e-4
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.state.cause);
    swing(20, 100, 0.02, 0.0071);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.state.cause);
}

static void test_turns_of_a_force_of_the_other_sign_are_not_hunting(void)
{
    swing(100, 100, -0.005, 0.0);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.state.cause);
}

static void test_one_slow_turn_forgives(void)
{
    for (int i = 0; i < 10; i++)
    {
        swing(14, 50, 0.02, 0.0);
        swing(2, 300, 0.02, 0.0);
    }
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.state.cause);
}

static void test_friction_that_turns_by_less_than_its_width_does_not_turn(void)
{
    for (int k = 0; k < 10000; k++)
    {
        const double sign = k % 20 < 10 ? 1.0 : -1.0;
        (void)guard_step(&guard, 0.5, 0.5 + 0.001 * sign * (k % 10), sign * 0.0249);
    }
    TEST_ASSERT_EQUAL_UINT8(0, guard.state.turns);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.state.cause);
}

/// `reversals`, each of 1 s; the largest error is `wrong_n` beyond r in the direction of f, and `right_n` behind it.
static void reverse(int reversals, double wrong_n, double right_n)
{
    for (int i = 0; i < reversals; i++)
    {
        const double sign = i % 2 == 0 ? 1.0 : -1.0;
        for (int k = 0; k < 1000; k++)
        {
            const double e = k == 300 ? -wrong_n : k == 600 ? right_n : 0.0;
            (void)guard_step(&guard, 0.5, 0.5 - sign * e, sign * 0.1);
        }
    }
}

static void test_four_breakaways_with_the_wrong_error_are_overshoot(void)
{
    reverse(5, 0.0141, 0.004); // the first only begins, the last has not ended
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.state.cause);
    TEST_ASSERT_EQUAL_UINT8(3, guard.state.strays);
    (void)guard_step(&guard, 0.5, 0.5, -0.1);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_OVERSHOOT, guard.state.cause);
}

static void test_breakaways_with_the_right_error_or_little_of_the_wrong_one_are_not(void)
{
    reverse(50, 0.0139, 0.004);
    reverse(50, 0.0, 0.2);
    TEST_ASSERT_EQUAL_UINT8(0, guard.state.strays);
    for (int i = 0; i < 10; i++)
    {
        reverse(2, 0.1, 0.0);
        reverse(2, 0.0, 0.1);
    }
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.state.cause);
}

/// Steps of constant signals until fade is `end`; in ticks. It moves by the same in each.
static int ticks_to(double end, double from)
{
    double before = from;
    for (int k = 1;; k++)
    {
        const double fade = guard_step(&guard, 0.5, 0.5, -0.1);
        TEST_ASSERT_TRUE(fade != before && fabs(fade - before) < 0.00201);
        before = fade;
        if (fade == end || k > 600)
        {
            return k;
        }
    }
}

static void test_friction_fades_in_half_a_second_stays_away_and_comes_back_as_slowly(void)
{
    swing(17, 20, 0.02, 0.0);
    TEST_ASSERT_TRUE(guard_step(&guard, 0.5, 0.51, 0.1) == 1.0);
    TEST_ASSERT_INT_WITHIN(1, 500, ticks_to(0.0, 1.0));
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.state.cause);
    TEST_ASSERT_TRUE(guard_step(&guard, 0.5, 0.5, 0.0) == 0.0);
    reverse(20, 0.1, 0.0); // another cause does not replace the first
    TEST_ASSERT_TRUE(guard_step(&guard, 0.5, 0.5, 0.0) == 0.0);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.state.cause);
    guard_restore(&guard);
    TEST_ASSERT_INT_WITHIN(1, 500, ticks_to(1.0, 0.0));
    TEST_ASSERT_TRUE(guard_step(&guard, 0.5, 0.5, -0.1) == 1.0);
}

static void test_a_guard_that_is_restored_lets_friction_back_and_judges_anew(void)
{
    swing(60, 20, 0.02, 0.0);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.state.cause);
    TEST_ASSERT_TRUE(guard_step(&guard, 0.5, 0.5, 0.1) == 0.0);
    guard_restore(&guard);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.state.cause);
    TEST_ASSERT_DOUBLE_WITHIN(GUARD_ROUNDING, 0.002, guard_step(&guard, 0.5, 0.5, 0.1));
    swing(10, 100, 0.02, 0.0);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.state.cause);
    TEST_ASSERT_TRUE(guard_step(&guard, 0.5, 0.5, 0.1) == 1.0);
    swing(12, 100, 0.02, 0.0);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.state.cause);
}

static void test_a_guard_that_is_switched_off_lets_friction_back_and_forgets(void)
{
    swing(60, 20, 0.02, 0.0);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.state.cause);
    guard.params.on = 0u;
    TEST_ASSERT_DOUBLE_WITHIN(GUARD_ROUNDING, 0.002, guard_step(&guard, 0.5, 0.5, 0.1));
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.state.cause);
    swing(60, 20, 0.02, 0.0); // nobody watches
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.state.cause);
    TEST_ASSERT_TRUE(guard_step(&guard, 0.5, 0.5, 0.1) == 1.0);
}

static void test_whatever_the_signals_the_fade_is_within_0_and_1(void)
{
    random_t r = {5};
    for (int k = 0; k < 200000; k++)
    {
        const double scale = k % 1000 < 500 ? 1.0 : 1.0e6;
        const double x     = random_between(&r, -1.1, 1.1) * scale;
        const double fade  = guard_step(&guard, random_between(&r, -1.0, 1.0), x, -x);
        TEST_ASSERT_TRUE(fade >= 0.0 && fade <= 1.0);
        if (k % 5000 == 0)
        {
            guard_restore(&guard);
        }
    }
}

static void test_it_judges_nothing_by_what_is_beyond_the_scale_or_no_number(void)
{
    const double bad[] = {(double)NAN, (double)INFINITY, -(double)INFINITY, 1e9, -1e9};
    swing(3, 100, 0.02, 0.0);
    const guard_t before = guard;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
    {
        (void)guard_step(&guard, bad[i], 0.5, -0.1);
        (void)guard_step(&guard, 0.5, bad[i], -0.1);
    }
    TEST_ASSERT_EQUAL_MEMORY(&before.state, &guard.state, sizeof before.state);
}

static void check(float *field, float bad, tribo_status_t expected)
{
    const float   good = *field;
    const guard_t was  = guard;
    *field             = bad;
    TEST_ASSERT_EQUAL_INT(expected, guard_init(&guard, &config, H));
    *field = NAN;
    TEST_ASSERT_EQUAL_INT(expected, guard_init(&guard, &config, H));
    TEST_ASSERT_EQUAL_MEMORY(&was.params, &guard.params, sizeof guard.params);
    *field = good;
}

static void test_set_up_names_the_field_that_is_wrong(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, guard_init(NULL, &config, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, guard_init(&guard, NULL, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SAMPLE_TIME, guard_init(&guard, &config, 0.2));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SAMPLE_TIME, guard_init(&guard, &config, (double)NAN));
    check(&config.turn_n, 0.0f, TRIBO_ERR_GUARD_TURN);
    check(&config.turn_n, 2.0e6f, TRIBO_ERR_GUARD_TURN);
    check(&config.quick_time_s, 0.0f, TRIBO_ERR_GUARD_QUICK_TIME);
    check(&config.quick_time_s, 101.0f, TRIBO_ERR_GUARD_QUICK_TIME); // 1e5 samples
    check(&config.fade_time_s, 0.0f, TRIBO_ERR_GUARD_FADE_TIME);
    check(&config.fade_time_s, 2.0e3f, TRIBO_ERR_GUARD_FADE_TIME);
    check(&config.stray_n, 0.0f, TRIBO_ERR_GUARD_STRAY);
    check(&config.stray_n, 2.0e6f, TRIBO_ERR_GUARD_STRAY);
    config.quick_time_s = 2000.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_GUARD_QUICK_TIME, guard_init(&guard, &config, 0.1));
}

static void test_a_fade_time_below_a_tick_fades_at_once(void)
{
    config.fade_time_s = 1.0e-6f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, guard_init(&guard, &config, H));
    swing(17, 20, 0.02, 0.0);
    (void)guard_step(&guard, 0.5, 0.51, 0.1);
    TEST_ASSERT_TRUE(guard_step(&guard, 0.5, 0.5, -0.1) == 0.0);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.state.cause);
}

// In f32 a step of less than 2^-25 would leave a fade of 1 as it is.
static void test_the_longest_fade_time_fades_and_a_longer_one_is_refused(void)
{
    config.fade_time_s = 1.0e3f; // 1e6 samples
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, guard_init(&guard, &config, H));
    guard.state.cause = TRIBO_GUARD_HUNTING;
    for (int k = 0; k < 1000; k++)
    {
        (void)guard_step(&guard, 0.5, 0.5, 0.1);
    }
    TEST_ASSERT_DOUBLE_WITHIN(5e-5, 1e-3, 1.0 - guard_step(&guard, 0.5, 0.5, 0.1));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_GUARD_FADE_TIME, guard_init(&guard, &config, 0.99 * H));
}

static void test_a_corrupt_cause_is_a_cause_that_has_a_name(void)
{
    guard.state.cause = (tribo_guard_cause_t)64;
    reverse(5, 0.1, 0.0);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_OVERSHOOT, guard.state.cause);
}

/// A sign of INT32_MIN has no negative of its width.
static void test_a_corrupt_sign_of_the_last_move_is_judged_once_and_replaced(void)
{
    const int32_t corrupt[] = {INT32_MIN, INT32_MIN + 1, -2, 2, INT32_MAX};
    for (uint32_t i = 0; i < 5u; i++)
    {
        reverse(2, 0.1, 0.0);
        guard.state.play.sign = corrupt[i];
        const double fade     = guard_step(&guard, 0.5, 0.5, 0.1);
        TEST_ASSERT_TRUE(fade >= 0.0 && fade <= 1.0);
        TEST_ASSERT_EQUAL_INT32(1, guard.state.play.sign);
    }
}

#include "runners/test_guard.inc" // main
