// Maxwell slip: hysteresis with non-local memory by Masing's rules, Stribeck effect, friction lag, no drift.

#define TRUTH sim_maxwell_slip_truth
#include "slide_rig.h"

#include <math.h>
#include <stdio.h>

static void test_an_inner_loop_closes_and_is_forgotten(void)
{
    TEST_ASSERT_TRUE(rig_inner_loop(&rig) < 1e-4 * L);
    // One state cannot do that.
    rig_init(&rig, &sim_dahl_truth);
    TEST_ASSERT_TRUE(rig_inner_loop(&rig) > 0.005 * L);
}

/// f after a turn at x0 is f0 - 2 f_virgin((x0 - x) / 2).
static void test_a_branch_is_the_first_curve_at_twice_the_scale(void)
{
    const double x0 = 1.5e-3;
    for (double x = 2e-4; x < 3e-3; x += 4e-4)
    {
        rig_slide_start(&slide, &rig, 0.5);
        const double virgin = rig_slide_by(&slide, 0.5 * x, 1e-3, 1e-4);
        const double f0     = rig_slide_by(&slide, x0 - 0.5 * x, 1e-3, 1e-4);
        TEST_ASSERT_DOUBLE_WITHIN(2e-3 * L, f0 - 2.0 * virgin, rig_slide_by(&slide, -x, 1e-3, 1e-4));
        rig_slide_end(&slide);
    }
}

static void test_presliding_does_not_depend_on_speed(void)
{
    rig_slide_start(&slide, &rig, 0.5);
    const double slow = rig_slide_by(&slide, 4e-4, 1e-3, 1e-3);
    rig_slide_end(&slide);
    rig_slide_start(&slide, &rig, 0.5);
    TEST_ASSERT_DOUBLE_WITHIN(2e-3 * L, slow, rig_slide_by(&slide, 4e-4, 1.0, 1e-6));
}

static void test_steady_friction_follows_the_stribeck_curve(void)
{
    rig_set(&rig, "sliding_ratio", 0.7);
    rig_slide_start(&slide, &rig, 0.5);
    for (double speed = 0.001; speed < 0.1; speed *= 2.0)
    {
        const double part = speed / 0.01;
        TEST_ASSERT_DOUBLE_WITHIN(1e-5 * L,
                                  L * (0.7 + 0.3 * exp(-part * part)),
                                  rig_slide_by(&slide, 0.02, speed, 1e-4));
    }
}

/// C = 80 N/s: after a jump of speed friction goes to the new level with a time constant of s / C, here 1.4 ms.
static void test_friction_lags_speed(void)
{
    rig_set(&rig, "sliding_ratio", 0.7);
    rig_slide_start(&slide, &rig, 0.5);
    const double before = rig_slide_by(&slide, 0.02, 0.001, 1e-4);
    for (int i = 0; i < 140; i++)
    {
        (void)rig_slide_step(&slide, 0.1, 1e-5);
    }
    const double after = 0.7 * L;
    const double lag   = 0.0014 * 80.0 / after;
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * L, after + (before - after) * exp(-lag), slide.f_n);
}

static void test_it_does_not_drift_in_presliding(void)
{
    const double drift = rig_drift(&rig, 0.1);
    printf("drift in 50 swings: %.2e N\n", drift);
    TEST_ASSERT_DOUBLE_WITHIN(2e-6, 0.0, drift);
}

static void test_bristles_that_stiffen_need_the_same_way_at_each_load(void)
{
    TEST_ASSERT_TRUE(rig_part_after(&rig, 2e-4, 0.2) > 1.3 * rig_part_after(&rig, 2e-4, 0.5));
    rig_set(&rig, "stiffens", 1.0);
    const double part = rig_part_after(&rig, 2e-3, 0.5);
    printf("after 0.002 deg: %.3f of L\n", part);
    TEST_ASSERT_TRUE(part > 0.1 && part < 0.9);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, part, rig_part_after(&rig, 2e-3, 0.2));
}

/// 0.0002 deg is the way of the first element at 0.5 N: L times 0.25 over a stiffness of 200 N/deg.
static void test_a_smaller_exponent_has_more_friction_at_once(void)
{
    const double expected[] = {0.48, 0.1};
    const double exponent[] = {-1.0, 1.0};
    for (int i = 0; i < 2; i++)
    {
        rig_set(&rig, "exponent", exponent[i]);
        rig_slide_start(&slide, &rig, 0.5);
        const double way   = 0.25 * L / 200.0;
        const double first = rig_slide_by(&slide, way, 1e-3, 1e-4) / L;
        const double next  = rig_slide_by(&slide, way, 1e-3, 1e-4) / L;
        // The others are springs until their own way: their part of L over 8/3, 6 and 16 times that of the first.
        const double springs =
            i == 0 ? 0.24 / (8.0 / 3.0) + 0.16 / 6.0 + 0.12 / 16.0 : 0.2 / (8.0 / 3.0) + 0.3 / 6.0 + 0.4 / 16.0;
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, expected[i] + springs, first);
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, first + springs, next);
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, 1.0, rig_slide_by(&slide, 16.0 * way, 1e-3, 1e-4) / L);
        rig_slide_end(&slide);
    }
}

#include "runners/test_maxwell_slip.inc" // main
