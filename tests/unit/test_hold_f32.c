#include "tribo/hold_f32.h"

#include "same.h"
#include "unity.h"

#include <math.h>

#define H 1.0e-3f

static tribo_hold_f32_config_t config;
static tribo_hold_f32_params_t params;
static tribo_hold_f32_state_t  hold;

void setUp(void)
{
    config = tribo_hold_f32_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_hold_f32_init(&params, &config, H));
    tribo_hold_f32_reset(&hold, 0.5f);
}

void tearDown(void)
{
}

static bool stands_for(int ticks, float reference)
{
    bool stands = false;
    for (int k = 0; k < ticks; k++)
    {
        stands = tribo_hold_f32_stands(&params, &hold, reference, 2.5e-4f, false);
    }
    return stands;
}

static void test_a_reference_stands_when_it_has_for_the_still_time(void)
{
    TEST_ASSERT_FALSE(stands_for(1500, 0.5f));
    TEST_ASSERT_TRUE(stands_for(2, 0.5f));
    TEST_ASSERT_TRUE(stands_for(100000, 0.5002f)); // within the width
    TEST_ASSERT_FALSE(stands_for(1, 0.5003f));
    TEST_ASSERT_FALSE(stands_for(1400, 0.5003f));
    TEST_ASSERT_TRUE(stands_for(102, 0.5001f));
}

static void test_a_step_of_a_reference_that_stands_leaves_it_standing(void)
{
    TEST_ASSERT_TRUE(stands_for(1502, 0.5f));
    hold.active = true;
    TEST_ASSERT_TRUE(tribo_hold_f32_stands(&params, &hold, 0.7f, 2.5e-4f, true));
    TEST_ASSERT_TRUE(stands_for(1, 0.7f));
    TEST_ASSERT_FALSE(tribo_hold_f32_stands(&params, &hold, 0.71f, 2.5e-4f, false));
    hold.active = false; // and one that does not, does not
    TEST_ASSERT_TRUE(stands_for(1502, 0.7f));
    TEST_ASSERT_FALSE(tribo_hold_f32_stands(&params, &hold, 0.5f, 2.5e-4f, true));
}

static void test_without_gain_nothing_ever_stands(void)
{
    config.gain = 0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_hold_f32_init(&params, &config, H));
    TEST_ASSERT_FALSE(stands_for(10000, 0.5f));
}

static void test_a_bad_reference_does_not_stand(void)
{
    TEST_ASSERT_TRUE(stands_for(1502, 0.5f));
    TEST_ASSERT_FALSE(stands_for(1, NAN));
    TEST_ASSERT_FALSE(stands_for(1000, 0.5f));
    TEST_ASSERT_FALSE(tribo_hold_f32_stands(&params, &hold, 0.5f, INFINITY, false));
    tribo_hold_f32_reset(&hold, NAN);
    TEST_ASSERT_SAME_FLOAT(0.0f, hold.anchor_n);
}

static void test_friction_is_what_the_arm_holds_back_less_a_margin(void)
{
    tribo_hold_f32_enter(&hold, 0.6f, 0.1f, 1, 0.5f);
    TEST_ASSERT_TRUE(hold.active);
    // Inside: f = gain (u - force), the force at 0.5 N.
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.95f * 0.08f, tribo_hold_f32_step(&params, &hold, 0.58f, 0.2f, 0.1f));
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.95f * -0.05f, tribo_hold_f32_step(&params, &hold, 0.45f, 0.2f, 0.1f));
    // At its ends: 0.85 of the breakaway, and the force goes along.
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.95f * 0.85f * 0.2f, tribo_hold_f32_step(&params, &hold, 0.8f, 0.2f, 0.1f));
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.63f, hold.play.position_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.95f * -0.085f, tribo_hold_f32_step(&params, &hold, 0.4f, 0.2f, 0.1f));
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.485f, hold.play.position_n);
    TEST_ASSERT_EQUAL_INT32(-1, hold.play.way);
}

/// From one side to the other, `ticks` after the last time.
static void change_side(int ticks)
{
    static float u = 1.0f;
    u              = 1.0f - u;
    for (int k = 0; k < ticks; k++)
    {
        (void)tribo_hold_f32_step(&params, &hold, u, 0.1f, 0.1f);
    }
}

static void test_quick_changes_of_side_make_it_cautious_and_slow_ones_do_not(void)
{
    tribo_hold_f32_enter(&hold, 0.6f, 0.1f, 0, 0.5f);
    for (int i = 0; i < 20; i++)
    {
        change_side(250);
    }
    TEST_ASSERT_SAME_FLOAT(0.0f, hold.caution);
    // The first is late after the last; then four in succession.
    for (int i = 0; i < 4; i++)
    {
        change_side(150);
    }
    TEST_ASSERT_SAME_FLOAT(0.0f, hold.caution);
    change_side(150);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.1f, hold.caution);
    change_side(150);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.19f, hold.caution);
    // Its breakaway is smaller by that.
    TEST_ASSERT_FLOAT_WITHIN(1e-6f,
                             0.95f * 0.81f * 0.85f * 0.1f,
                             fabsf(tribo_hold_f32_step(&params, &hold, hold.play.way > 0 ? 9.0f : -9.0f, 0.1f, 0.1f)));
    for (int i = 0; i < 200; i++)
    {
        change_side(3);
    }
    TEST_ASSERT_TRUE(hold.caution > 0.99f && hold.caution <= 1.0f);
}

static void test_learning_takes_caution_back(void)
{
    hold.caution = 0.5f;
    for (int k = 0; k < 1000; k++)
    {
        tribo_hold_f32_learned(&params, &hold, 1e-4f);
    }
    TEST_ASSERT_FLOAT_WITHIN(2e-3f, 0.5f * expf(-1.0f), hold.caution);
    const float before = hold.caution;
    tribo_hold_f32_learned(&params, &hold, NAN);
    tribo_hold_f32_learned(&params, &hold, -1.0f);
    TEST_ASSERT_SAME_FLOAT(before, hold.caution);
    tribo_hold_f32_learned(&params, &hold, 1.0f);
    TEST_ASSERT_SAME_FLOAT(0.0f, hold.caution);
}

static void test_the_deadband_takes_a_lasting_error_up_to_a_share_of_the_noise(void)
{
    tribo_hold_f32_enter(&hold, 0.6f, 0.1f, 1, 0.5f);
    float e = 0.0f;
    for (int k = 0; k < 5000; k++) // y swings by 1 mN each tick: second differences of 2 mN, changed in all ticks
    {
        e = tribo_hold_f32_deadband(&params, &hold, 0.01f, 0.5f + (k % 2 == 0 ? 1e-3f : 0.0f));
    }
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 0.01f - 0.13f * 2e-3f, e);
    // Coarse: y changes in few ticks.
    tribo_hold_f32_enter(&hold, 0.6f, 0.1f, 1, 0.5f);
    for (int k = 0; k < 20000; k++)
    {
        e = tribo_hold_f32_deadband(&params, &hold, -0.01f, 0.5f + ((k / 500) % 2 == 0 ? 1e-3f : 0.0f));
    }
    TEST_ASSERT_FLOAT_WITHIN(5e-5f, -0.01f + 0.6f * 1e-3f, e);
    // A small error goes altogether.
    for (int k = 0; k < 5000; k++)
    {
        e = tribo_hold_f32_deadband(&params, &hold, 1e-4f, 0.5f + ((k / 500) % 2 == 0 ? 1e-3f : 0.0f));
    }
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.0f, e);
}

static void test_hold_takes_bad_inputs(void)
{
    const float bad[] = {NAN, INFINITY, -1.1e6f};
    tribo_hold_f32_enter(&hold, 0.6f, 0.1f, 1, 0.5f);
    const tribo_hold_f32_state_t before = hold;
    for (int i = 0; i < 3; i++)
    {
        TEST_ASSERT_SAME_FLOAT(0.0f, tribo_hold_f32_step(&params, &hold, bad[i], 0.1f, 0.1f));
        TEST_ASSERT_SAME_FLOAT(0.0f, tribo_hold_f32_step(&params, &hold, 0.5f, bad[i], 0.1f));
        TEST_ASSERT_SAME_FLOAT(0.0f, tribo_hold_f32_step(&params, &hold, 0.5f, 0.1f, bad[i]));
        TEST_ASSERT_SAME_FLOAT(0.01f, tribo_hold_f32_deadband(&params, &hold, 0.01f, bad[i]));
        TEST_ASSERT_EQUAL_HEX32(same_bits(bad[i]), same_bits(tribo_hold_f32_deadband(&params, &hold, bad[i], 0.5f)));
    }
    TEST_ASSERT_EQUAL_MEMORY(&before, &hold, sizeof hold);
    tribo_hold_f32_enter(&hold, NAN, NAN, 1, NAN);
    TEST_ASSERT_SAME_FLOAT(0.0f, hold.play.position_n);
    TEST_ASSERT_SAME_FLOAT(0.0f, hold.y_n[0]);
}

static void check(float *field, float value, tribo_status_t status)
{
    const tribo_hold_f32_params_t before = params;
    const float                   kept   = *field;
    *field                               = value;
    TEST_ASSERT_EQUAL_INT(status, tribo_hold_f32_init(&params, &config, H));
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
    *field = kept;
}

static void test_hold_init_names_the_field(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_hold_f32_init(NULL, &config, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_hold_f32_init(&params, NULL, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SAMPLE_TIME, tribo_hold_f32_init(&params, &config, 0.0f));
    check(&config.gain, 1.0f, TRIBO_ERR_HOLD_GAIN);
    check(&config.still_time_s, NAN, TRIBO_ERR_HOLD_TIME);
    check(&config.quick_time_s, 0.0f, TRIBO_ERR_HOLD_TIME);
    check(&config.margin, 1.1f, TRIBO_ERR_HOLD_MARGIN);
    check(&config.caution_travel_n, 0.0f, TRIBO_ERR_HOLD_CAUTION);
    check(&config.deadband_time_s, 0.0f, TRIBO_ERR_HOLD_DEADBAND);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_reference_stands_when_it_has_for_the_still_time);
    RUN_TEST(test_a_step_of_a_reference_that_stands_leaves_it_standing);
    RUN_TEST(test_without_gain_nothing_ever_stands);
    RUN_TEST(test_a_bad_reference_does_not_stand);
    RUN_TEST(test_friction_is_what_the_arm_holds_back_less_a_margin);
    RUN_TEST(test_quick_changes_of_side_make_it_cautious_and_slow_ones_do_not);
    RUN_TEST(test_learning_takes_caution_back);
    RUN_TEST(test_the_deadband_takes_a_lasting_error_up_to_a_share_of_the_noise);
    RUN_TEST(test_hold_takes_bad_inputs);
    RUN_TEST(test_hold_init_names_the_field);
    return UNITY_END();
}
