// The loop on the plant with each fault at many ticks: it stays within its limits, counts the fault, and recovers.

#include "rig.h"
#include "unity.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

#define TICKS 6000

static rig_t rig;

void setUp(void)
{
    const tribo_force_loop_f32_config_t config = tribo_force_loop_f32_paper();
    rig_open(&rig, &config);
}

void tearDown(void)
{
    rig_close(&rig);
}

/// Runs with the sensor reading `fault` for `length` ticks from tick `at`. Returns the largest |r - F| later than two seconds
/// after the fault.
static double run_with_fault(double fault, int at, int length)
{
    double       worst = 0.0;
    const double limit = 2.0;
    for (int k = 0; k < TICKS; k++)
    {
        const double r = rig_triangle(k);
        const double y = k >= at && k < at + length ? fault : rig_sensor(&rig);
        const double u = rig_tick(&rig, &rig.loop, r, y);
        TEST_ASSERT_TRUE(isfinite(u) && fabs(u) <= limit);
        worst = k >= at + length + 2000 ? fmax(worst, fabs(r - rig_force(&rig))) : worst;
    }
    return worst;
}

static void test_a_sensor_fault_at_any_tick_is_survived_and_counted(void)
{
    const double faults[] =
        {(double)NAN, (double)INFINITY, -(double)INFINITY, (double)FLT_MAX, -(double)FLT_MAX, 2.5, 1e-45};
    for (size_t i = 0; i < sizeof faults / sizeof faults[0]; i++)
    {
        for (int at = 100; at <= 3500; at += 425)
        {
            tearDown();
            setUp();
            TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.0, run_with_fault(faults[i], at, 5));
            TEST_ASSERT_EQUAL_UINT32(i < 6 ? 5u : 0u, loop_bad_inputs(&rig.loop));
        }
    }
}

// A bad sample makes the loop coast: u moves less than normally within a few ticks.
static void test_a_bad_sample_does_not_kick_the_output(void)
{
    double u = 0.0;
    for (int k = 0; k < 3000; k++)
    {
        u = rig_tick(&rig, &rig.loop, rig_triangle(k), rig_sensor(&rig));
    }
    for (int k = 3000; k < 3005; k++)
    {
        const double coasting = rig_tick(&rig, &rig.loop, rig_triangle(k), (double)NAN);
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, u, coasting);
        u = coasting;
    }
}

static void test_the_loop_leaves_a_long_limit_without_overshoot(void)
{
    tribo_force_loop_f32_config_t config = tribo_force_loop_f32_paper();
    config.controller.u_max_n = 0.5f; // F cannot slide beyond (0.5 - 0.007)/1.3 = 0.379 N, but a step overshoots
    tearDown();
    rig_open(&rig, &config);
    for (int k = 0; k < 20000; k++)
    {
        (void)rig_tick(&rig, &rig.loop, 0.6, rig_sensor(&rig));
    }
    TEST_ASSERT_TRUE(loop_limited_ticks(&rig.loop) > 19000u);
    const double held = rig_force(&rig);
    TEST_ASSERT_DOUBLE_WITHIN(0.03, 0.379, held);
    // The reference falls below the held force: the loop leaves its limit within 50 ms and follows.
    double lowest = held;
    for (int k = 0; k < 3000; k++)
    {
        (void)rig_tick(&rig, &rig.loop, 0.3, rig_sensor(&rig));
        TEST_ASSERT_TRUE(k < 50 || !rig.seen.limited);
        lowest = fmin(lowest, rig_force(&rig));
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.005, 0.3, rig_force(&rig));
    TEST_ASSERT_TRUE(lowest > 0.28);
}

static void test_retuning_on_the_plant_does_not_show_in_the_force(void)
{
    tribo_force_loop_f32_config_t config = tribo_force_loop_f32_paper();
    loop_t                        other;
    config.gain                                = 0.4f;
    config.compensator.friction.positive.slope = 0.25f;
    config.compensator.friction.negative.slope = 0.25f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&other, &config));
    double worst_step   = 0.0; // of u, without a change
    double worst_change = 0.0; // in the tick of a change and the next
    double worst_error  = 0.0;
    double u            = 0.0;
    for (int k = 0; k < 30000; k++)
    {
        const bool   other_turn = (k / 1000) % 2 == 1; // every second
        const double last       = u;
        u                       = rig_tick(&rig, other_turn ? &other : &rig.loop, rig_triangle(k), rig_sensor(&rig));
        worst_step              = k > 3000 && k % 1000 > 20 ? fmax(worst_step, fabs(u - last)) : worst_step;
        worst_change            = k > 3000 && k % 1000 <= 1 ? fmax(worst_change, fabs(u - last)) : worst_change;
        worst_error             = k > 3000 ? fmax(worst_error, fabs(rig_triangle(k) - rig_force(&rig))) : worst_error;
    }
    // A single jump would be 0.45 f^ or more, about 0.1 N.
    TEST_ASSERT_TRUE(worst_change <= worst_step);
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 0.0, worst_error);
    printf("u moves by up to %.1e N a tick, by %.1e N when params change\n", worst_step, worst_change);
}

#include "runners/test_faults.inc" // main
