#include "tribo/friction_meter_f32.h"

#include "same.h"
#include "unity.h"

#include <math.h>

#define H 1.0e-3f

static tribo_path_f32_config_t            path;
static tribo_friction_meter_f32_params_t  params;
static tribo_friction_meter_f32_state_t   meter;
static tribo_friction_meter_f32_signals_t seen;

void setUp(void)
{
    path = tribo_path_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_meter_f32_init(&params, &path, 0.02f, H));
    tribo_friction_meter_f32_reset(&meter, 0.3f);
}

void tearDown(void)
{
}

/// F rises by `rate` in N/s from 0.3 N against friction `L`, which the motor overcomes, behind its pole, and the damping.
static void slide(double rate, double L)
{
    const double actuator = -expm1(-0.2);
    const double sensor   = -expm1(-0.055);
    double       F        = 0.3;
    double       y        = 0.3;
    for (int k = 0; k < 2000; k++)
    {
        const double pushed = F + 0.0288 / 3.84 * rate + L;
        const double u      = pushed - rate * 1e-3 + rate * 1e-3 / actuator; // what the actuator makes `pushed` of
        F += rate * 1e-3;
        tribo_friction_meter_f32_step(&params, &meter, (float)u, (float)y, &seen);
        y += sensor * (F - y);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, y - rate * 0.02, (double)seen.force_n);
}

static void test_meter_shows_friction_of_a_steady_slide_with_the_sign_of_the_way(void)
{
    slide(0.02, 0.05);
    TEST_ASSERT_DOUBLE_WITHIN(5e-5, 0.05, (double)seen.friction_n);
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, 2e-5, (double)seen.change_n);
    tribo_friction_meter_f32_reset(&meter, 0.3f);
    slide(-0.04, -0.08);
    TEST_ASSERT_DOUBLE_WITHIN(5e-5, -0.08, (double)seen.friction_n);
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, -4e-5, (double)seen.change_n);
}

static void test_meter_shows_what_the_motor_pushes_while_the_arm_sticks(void)
{
    for (int k = 0; k < 1000; k++)
    {
        tribo_friction_meter_f32_step(&params, &meter, 0.35f, 0.3f, &seen);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.05, (double)seen.friction_n);
    TEST_ASSERT_SAME_FLOAT(0.3f, seen.force_n);
    TEST_ASSERT_SAME_FLOAT(0.0f, seen.change_n);
}

static void test_meter_stands_still_for_a_bad_input(void)
{
    slide(0.02, 0.05);
    const tribo_friction_meter_f32_state_t before = meter;
    const float                            bad[]  = {NAN, INFINITY, -1.1e6f};
    for (int i = 0; i < 3; i++)
    {
        tribo_friction_meter_f32_step(&params, &meter, bad[i], 0.3f, &seen);
        tribo_friction_meter_f32_step(&params, &meter, 0.3f, bad[i], &seen);
    }
    TEST_ASSERT_EQUAL_MEMORY(&before, &meter, sizeof meter);
    TEST_ASSERT_SAME_FLOAT(before.y_n + before.behind_n, seen.force_n);
    TEST_ASSERT_SAME_FLOAT(0.0f, seen.change_n);
    tribo_friction_meter_f32_reset(&meter, NAN);
    TEST_ASSERT_SAME_FLOAT(0.0f, meter.y_n);
}

static void test_meter_init_names_the_field(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_friction_meter_f32_init(NULL, &path, 0.02f, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_friction_meter_f32_init(&params, NULL, 0.02f, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SLIDE_FILTER, tribo_friction_meter_f32_init(&params, &path, NAN, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SLIDE_FILTER, tribo_friction_meter_f32_init(&params, &path, 11.0f, H));
    path.sensor_pole_rad_per_s = -1.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SENSOR_POLE, tribo_friction_meter_f32_init(&params, &path, 0.02f, H));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_meter_shows_friction_of_a_steady_slide_with_the_sign_of_the_way);
    RUN_TEST(test_meter_shows_what_the_motor_pushes_while_the_arm_sticks);
    RUN_TEST(test_meter_stands_still_for_a_bad_input);
    RUN_TEST(test_meter_init_names_the_field);
    return UNITY_END();
}
