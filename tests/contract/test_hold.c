#include PARTS_HEADER
#include "random.h"
#include "unity.h"

#include <math.h>

#define H    1e-3
#define HALF 2.5e-4 // N

static tribo_hold_f32_config_t config;
static hold_t                  hold;

void setUp(void)
{
    config = tribo_hold_f32_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, hold_init(&hold, &config, H));
}

void tearDown(void)
{
}

static bool stands_for(int ticks, double reference)
{
    bool stands = false;
    for (int k = 0; k < ticks; k++)
    {
        stands = hold_stands(&hold, reference, HALF, false);
    }
    return stands;
}

static void test_a_reference_stands_when_it_has_for_the_still_time(void)
{
    TEST_ASSERT_FALSE(stands_for(1501, 0.5)); // the first of them is a move
    TEST_ASSERT_TRUE(stands_for(2, 0.5));
    TEST_ASSERT_TRUE(stands_for(100000, 0.5002)); // within the width
    TEST_ASSERT_FALSE(stands_for(1, 0.5003));
    TEST_ASSERT_FALSE(stands_for(1400, 0.5003));
    TEST_ASSERT_TRUE(stands_for(102, 0.5001));
}

static void test_a_step_of_a_reference_in_a_hold_leaves_it_standing(void)
{
    TEST_ASSERT_TRUE(stands_for(1503, 0.5));
    hold_enter(&hold, 0.6, 0.1, 1, 0.5);
    TEST_ASSERT_TRUE(hold_stands(&hold, 0.7, HALF, true));
    TEST_ASSERT_TRUE(stands_for(1, 0.7));
    TEST_ASSERT_FALSE(hold_stands(&hold, 0.71, HALF, false));
}

static void test_a_step_of_a_reference_before_a_hold_does_not(void)
{
    TEST_ASSERT_TRUE(stands_for(1503, 0.7));
    TEST_ASSERT_FALSE(hold_stands(&hold, 0.5, HALF, true));
}

static void test_without_gain_nothing_ever_stands(void)
{
    config.gain = 0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, hold_init(&hold, &config, H));
    TEST_ASSERT_FALSE(stands_for(10000, 0.5));
}

static void test_friction_is_what_the_arm_holds_back_less_a_margin(void)
{
    hold_enter(&hold, 0.6, 0.1, 1, 0.5);
    // Inside: f = gain (u - force), the force at 0.5 N.
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.95 * 0.08, hold_step(&hold, 0.58, 0.2, 0.1));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.95 * -0.05, hold_step(&hold, 0.45, 0.2, 0.1));
    // At its ends: 0.85 of the breakaway, and the force goes along.
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.95 * 0.85 * 0.2, hold_step(&hold, 0.8, 0.2, 0.1));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.63, hold_position(&hold));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.95 * -0.085, hold_step(&hold, 0.4, 0.2, 0.1));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.485, hold_position(&hold));
    TEST_ASSERT_EQUAL_INT32(-1, hold.state.play.sign);
}

/// From one sign to the other, `ticks` after the last time.
static void change_sign(int ticks)
{
    static double u = 1.0;
    u               = 1.0 - u;
    for (int k = 0; k < ticks; k++)
    {
        (void)hold_step(&hold, u, 0.1, 0.1);
    }
}

static void test_quick_changes_of_sign_widen_the_margin_and_slow_ones_do_not(void)
{
    hold_enter(&hold, 0.6, 0.1, 0, 0.5);
    for (int i = 0; i < 20; i++)
    {
        change_sign(250);
    }
    TEST_ASSERT_TRUE(hold_extra_margin(&hold) == 0.0);
    // The first is late after the last; then four in succession.
    for (int i = 0; i < 4; i++)
    {
        change_sign(150);
    }
    TEST_ASSERT_TRUE(hold_extra_margin(&hold) == 0.0);
    change_sign(150);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.1, hold_extra_margin(&hold));
    change_sign(150);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.19, hold_extra_margin(&hold));
    // Its breakaway is smaller by that.
    const double beyond = hold.state.play.sign > 0 ? 1.9 : -1.9;
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.95 * 0.81 * 0.85 * 0.1, fabs(hold_step(&hold, beyond, 0.1, 0.1)));
    for (int i = 0; i < 200; i++)
    {
        change_sign(3);
    }
    TEST_ASSERT_TRUE(hold_extra_margin(&hold) > 0.99 && hold_extra_margin(&hold) <= 1.0);
}

static void test_learning_takes_the_extra_margin_back(void)
{
    hold_enter(&hold, 0.6, 0.1, 0, 0.5);
    for (int i = 0; i < 200; i++)
    {
        change_sign(3);
    }
    const double widest = hold_extra_margin(&hold);
    hold_learned(&hold, 0.0);
    TEST_ASSERT_TRUE(hold_extra_margin(&hold) == widest);
    for (int k = 0; k < 1000; k++)
    {
        hold_learned(&hold, 1e-4); // margin_travel_n altogether
    }
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, widest * exp(-1.0), hold_extra_margin(&hold));
}

static void test_the_deadband_takes_a_lasting_error_up_to_a_fraction_of_the_noise(void)
{
    hold_enter(&hold, 0.6, 0.1, 1, 0.5);
    double e = 0.0;
    for (int k = 0; k < 5000; k++) // y swings by 1 mN each tick: second differences of 2 mN, changed in all ticks
    {
        e = hold_deadband(&hold, 0.01, 0.5 + (k % 2 == 0 ? 1e-3 : 0.0));
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.01 - 0.13 * 2e-3, e);
    // Coarse: y changes in few ticks.
    hold_enter(&hold, 0.6, 0.1, 1, 0.5);
    for (int k = 0; k < 20000; k++)
    {
        e = hold_deadband(&hold, -0.01, 0.5 + (k / 500 % 2 == 0 ? 1e-3 : 0.0));
    }
    TEST_ASSERT_DOUBLE_WITHIN(5e-5, -0.01 + 0.6 * 1e-3, e);
    // A small error goes altogether.
    for (int k = 0; k < 5000; k++)
    {
        e = hold_deadband(&hold, 1e-4, 0.5 + (k / 500 % 2 == 0 ? 1e-3 : 0.0));
    }
    TEST_ASSERT_DOUBLE_WITHIN(HOLD_REST, 0.0, e);
}

static void test_a_hold_that_begins_forgets_the_last_one(void)
{
    static hold_t fresh;
    fresh = hold;
    hold_enter(&hold, 0.3, -0.1, -1, 0.2);
    for (int k = 0; k < 3000; k++)
    {
        (void)hold_step(&hold, k < 1500 ? 0.3 : 0.7, 0.2, 0.1);
        (void)hold_deadband(&hold, 0.01, 0.2 + (k % 3 == 0 ? 1e-3 : 0.0));
    }
    hold_enter(&hold, 0.6, 0.1, 1, 0.5);
    hold_enter(&fresh, 0.6, 0.1, 1, 0.5);
    for (int k = 0; k < 500; k++)
    {
        const double u = 0.6 - 1e-3 * k;
        const double y = 0.5 + (k % 2 == 0 ? 1e-3 : 0.0);
        TEST_ASSERT_TRUE(hold_step(&hold, u, 0.2, 0.1) == hold_step(&fresh, u, 0.2, 0.1));
        TEST_ASSERT_TRUE(hold_deadband(&hold, 1e-3, y) == hold_deadband(&fresh, 1e-3, y));
        TEST_ASSERT_EQUAL_INT32(fresh.state.play.sign, hold.state.play.sign);
    }
}

static void test_hold_is_a_mirror_image_to_the_last_bit(void)
{
    static hold_t mirror;
    random_t      r = {21};
    double        u = 0.5;
    mirror          = hold;
    hold_enter(&hold, 0.5, 0.1, 1, 0.5);
    hold_enter(&mirror, -0.5, -0.1, -1, -0.5);
    for (int k = 0; k < 100000; k++)
    {
        // Calm for 20 s, then from side to side in up to 0.3 s.
        u              = k < 20000                              ? u + random_between(&r, -1e-3, 1e-3)
                         : k == 20000                           ? 1.0
                         : random_between(&r, 0.0, 150.0) < 1.0 ? 1.0 - u
                                                                : u;
        const double y = k % 3 == 0 ? 0.5 : 0.5 + random_between(&r, -1e-3, 1e-3);
        const double e = random_between(&r, -1e-3, 2e-3);
        TEST_ASSERT_TRUE(hold_step(&hold, u, 0.2, 0.1) == -hold_step(&mirror, -u, 0.1, 0.2));
        TEST_ASSERT_TRUE(hold_deadband(&hold, e, y) == -hold_deadband(&mirror, -e, -y));
        TEST_ASSERT_TRUE(hold_extra_margin(&hold) == hold_extra_margin(&mirror));
        if (k % 1000 == 0)
        {
            hold_learned(&hold, 1e-3);
            hold_learned(&mirror, 1e-3);
        }
    }
    TEST_ASSERT_TRUE(hold_extra_margin(&hold) > 0.25);
}

static void check(float *field, float value, tribo_status_t status)
{
    const hold_t before = hold;
    const float  kept   = *field;
    *field              = value;
    TEST_ASSERT_EQUAL_INT(status, hold_init(&hold, &config, H));
    TEST_ASSERT_EQUAL_MEMORY(&before.params, &hold.params, sizeof hold.params);
    *field = kept;
}

static void test_hold_init_names_the_field(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, hold_init(NULL, &config, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, hold_init(&hold, NULL, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SAMPLE_TIME, hold_init(&hold, &config, 0.0));
    check(&config.gain, 1.0f, TRIBO_ERR_HOLD_GAIN);
    check(&config.still_time_s, NAN, TRIBO_ERR_HOLD_STILL_TIME);
    check(&config.quick_time_s, 0.0f, TRIBO_ERR_HOLD_QUICK_TIME);
    check(&config.margin, 1.1f, TRIBO_ERR_HOLD_MARGIN);
    check(&config.margin_travel_n, 0.0f, TRIBO_ERR_HOLD_MARGIN_TRAVEL);
    check(&config.deadband_time_s, 0.0f, TRIBO_ERR_HOLD_DEADBAND);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_reference_stands_when_it_has_for_the_still_time);
    RUN_TEST(test_a_step_of_a_reference_in_a_hold_leaves_it_standing);
    RUN_TEST(test_a_step_of_a_reference_before_a_hold_does_not);
    RUN_TEST(test_without_gain_nothing_ever_stands);
    RUN_TEST(test_friction_is_what_the_arm_holds_back_less_a_margin);
    RUN_TEST(test_quick_changes_of_sign_widen_the_margin_and_slow_ones_do_not);
    RUN_TEST(test_learning_takes_the_extra_margin_back);
    RUN_TEST(test_the_deadband_takes_a_lasting_error_up_to_a_fraction_of_the_noise);
    RUN_TEST(test_a_hold_that_begins_forgets_the_last_one);
    RUN_TEST(test_hold_is_a_mirror_image_to_the_last_bit);
    RUN_TEST(test_hold_init_names_the_field);
    return UNITY_END();
}
