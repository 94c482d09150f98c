#include PARTS_HEADER
#include "unity.h"

#include <math.h>
#include <string.h>

#define H 1e-3

static tribo_arm_f32_config_t config;
static arm_t                  arm;

void setUp(void)
{
    config = tribo_force_loop_f32_paper().compensator.arm;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, arm_init(&arm, &config, H));
}

static void test_arm_follows_the_continuous_step_response(void)
{
    double F = 0.0;
    for (int k = 1; k <= 60; k++)
    {
        F = arm_step(&arm, 1.0 - F);
        // Eq. (2) with I 1.2e-4, b 0.0288, K 3.84: sigma 120, omega_d sqrt(32000 - 14400)
        const double t     = k * H;
        const double w     = sqrt(32000.0 - 14400.0);
        const double exact = 1.0 - exp(-120.0 * t) * (cos(w * t) + 120.0 / w * sin(w * t));
        TEST_ASSERT_DOUBLE_WITHIN(ARM_TOLERANCE_N, exact, F);
    }
}

static void test_arm_comes_to_rest_where_the_force_balances(void)
{
    for (int k = 0; k < 1000; k++)
    {
        (void)arm_step(&arm, 0.5 - arm_force(&arm)); // u = 0.5 N, no friction
    }
    TEST_ASSERT_DOUBLE_WITHIN(ARM_REST_N, 0.5, arm_force(&arm));
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.0, arm_change(&arm));
}

static void test_arm_that_rests_and_sticks_does_not_move(void)
{
    for (int k = 0; k < 1000; k++)
    {
        (void)arm_step(&arm, 0.5 - arm_force(&arm));
    }
    for (int k = 0; k < 2000; k++) // it coasts a little, and less and less
    {
        (void)arm_step(&arm, 0.0);
    }
    const double F = arm_force(&arm);
    for (int k = 0; k < 100; k++)
    {
        TEST_ASSERT_TRUE(arm_step(&arm, 0.0) == F);
    }
}

static void test_arm_that_sticks_comes_to_rest_from_both_sides_alike(void)
{
    static arm_t mirror;
    mirror = arm;
    (void)arm_step(&arm, 0.4);
    (void)arm_step(&mirror, -0.4);
    TEST_ASSERT_TRUE(arm_change(&arm) > 0.0);
    for (int k = 0; k < 2000; k++)
    {
        TEST_ASSERT_TRUE(arm_step(&mirror, 0.0) == -arm_step(&arm, 0.0));
        TEST_ASSERT_TRUE(arm_change(&mirror) == -arm_change(&arm));
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-30, 0.0, arm_change(&arm));
}

static void test_arm_after_a_reset_is_at_rest(void)
{
    (void)arm_step(&arm, 0.4);
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, arm_init(&arm, &config, H));
    TEST_ASSERT_TRUE(arm_step(&arm, 0.0) == 0.0 && arm_change(&arm) == 0.0);
}

static void check_refused(tribo_status_t status, double h)
{
    static arm_t out;
    memset(&out, 0xa5, sizeof out);
    TEST_ASSERT_EQUAL_INT(status, arm_init(&out, &config, h));
    TEST_ASSERT_EACH_EQUAL_HEX8(0xa5, &out.params, sizeof out.params);
    config = tribo_force_loop_f32_paper().compensator.arm;
}

static void test_arm_init_checks_every_field(void)
{
    const float bad[] = {-1.0f, NAN, INFINITY, 0.0f};
    for (int i = 0; i < 4; i++)
    {
        config.inertia = bad[i];
        check_refused(TRIBO_ERR_INERTIA, H);
        config.stiffness = bad[i];
        check_refused(TRIBO_ERR_STIFFNESS, H);
    }
    for (int i = 0; i < 3; i++)
    {
        config.damping = bad[i];
        check_refused(TRIBO_ERR_DAMPING, H);
    }
    const double bad_h[] = {0.0, 0.9e-6, 0.101, (double)NAN, 0.2};
    for (int i = 0; i < 5; i++)
    {
        check_refused(TRIBO_ERR_SAMPLE_TIME, bad_h[i]);
    }
}

#include "runners/test_arm.inc" // main
