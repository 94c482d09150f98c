#include ARITH_HEADER
#if TRIBO_IS_Q31
#include "friction/compensator_q31.h"
#else
#include "friction/compensator_f32.h"
#endif
#include "unity.h"

#include <math.h>
#include <string.h>

#define H 1e-3

static tribo_compensator_f32_config_t config;
static compensator_t                  compensator;

void setUp(void)
{
    config = tribo_force_loop_f32_paper().compensator;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, compensator_init(&compensator, &config, H));
}

static void test_compensator_is_friction_and_arm_joined_as_in_fig_11(void)
{
    static friction_t friction;
    static arm_t      arm;
    config.friction.gravity_n = 0.01f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, compensator_init(&compensator, &config, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, friction_init(&friction, &config.friction, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, arm_init(&arm, &config.arm, H));
    for (int k = 0; k < 5000; k++)
    {
        const double             u        = 0.4 + 0.3 * sin(k * 0.004);
        const double             F        = arm_force(&arm);
        const friction_seen_t    expected = friction_step(&friction, u, F);
        const compensator_seen_t seen     = compensator_step(&compensator, u);
        (void)arm_step(&arm, expected.n - expected.f);
        TEST_ASSERT_TRUE(F == seen.F); // at the start of the tick
        TEST_ASSERT_TRUE(expected.n == seen.friction.n);
        TEST_ASSERT_TRUE(expected.f == seen.friction.f);
    }
    TEST_ASSERT_TRUE(arm_force(&arm) > 0.1);
}

static void test_compensator_force_follows_u_minus_breakaway_while_it_slides(void)
{
    compensator_seen_t seen = {.F = 0.0};
    for (int k = 0; k <= 60000; k++)
    {
        seen = compensator_step(&compensator, 1.0e-5 * k);
    }
    TEST_ASSERT_DOUBLE_WITHIN(2e-4, (0.6 - 0.007) / 1.3, seen.F); // u = F + 0.007 + 0.3 F
}

static void test_compensator_reset_is_rest(void)
{
    memset(&compensator.state, 0x5a, sizeof compensator.state);
    compensator_reset(&compensator);
    const compensator_seen_t seen = compensator_step(&compensator, 0.0);
    TEST_ASSERT_TRUE(seen.F == 0.0);
    TEST_ASSERT_TRUE(seen.friction.n == 0.0 && seen.friction.v == 0.0 && seen.friction.f == 0.0);
    TEST_ASSERT_FALSE(seen.friction.q1 || seen.friction.q2 || seen.friction.q);
    TEST_ASSERT_TRUE(compensator_step(&compensator, 0.0).F == 0.0);
}

static void check_refused(tribo_status_t status, double h)
{
    static compensator_t out;
    memset(&out, 0xa5, sizeof out);
    TEST_ASSERT_EQUAL_INT(status, compensator_init(&out, &config, h));
    TEST_ASSERT_EACH_EQUAL_HEX8(0xa5, &out.params, sizeof out.params);
}

/// Taken up under u at F, the arm is held by the friction of n = u - F + g; in the first tick n has not moved.
static void test_compensator_is_entered_with_the_net_force_of_its_gravity(void)
{
    config.friction.gravity_n = 0.02f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, compensator_init(&compensator, &config, H));
    const double u = 0.31;
    const double f = from_force(compensator_enter(&compensator.params, &compensator.state, to_force(u), to_force(0.3)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.03, f);
    const compensator_seen_t seen = compensator_step(&compensator, u);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.03, seen.friction.n);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.03, seen.friction.f);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.0, seen.friction.v);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.3, seen.F);
}

static void test_compensator_init_passes_on_what_its_parts_refuse(void)
{
    const tribo_compensator_f32_config_t good = config;
    check_refused(TRIBO_ERR_SAMPLE_TIME, 0.0);
    config.arm.stiffness = NAN;
    check_refused(TRIBO_ERR_STIFFNESS, H);
    config.friction.m = NAN;
    check_refused(TRIBO_ERR_M, H); // the friction first
    config                = good;
    config.friction.k_min = 0.0f;
    check_refused(TRIBO_ERR_K_MIN, H);
}

#include "runners/test_compensator.inc" // main
