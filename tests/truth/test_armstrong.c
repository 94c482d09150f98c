// Armstrong: breakaway rises with the time at rest; Stribeck effect, frictional memory, elastic presliding.

#define TRUTH sim_armstrong_truth
#include "slide_rig.h"

#include <math.h>
#include <stdio.h>

/// Breakaway friction after a slide at 0.1 deg/s and a rest.
static double breakaway_after(double rest_s)
{
    rig_slide_start(&slide, &rig, 0.5);
    (void)rig_slide_by(&slide, 0.02, 0.1, 1e-4);
    (void)rig_slide_by(&slide, -1e-4, 0.01, 1e-4); // stops against the spring
    for (int i = 0; i < (int)(rest_s / 1e-3); i++)
    {
        (void)rig_slide_step(&slide, 0.0, 1e-3);
    }
    double highest = 0.0;
    for (int i = 0; i < 600; i++)
    {
        highest = fmax(highest, rig_slide_step(&slide, 0.01, 1e-4));
    }
    rig_slide_end(&slide);
    return highest;
}

/// After a slide at 0.1 deg/s s is 1 / 101. In one second (the dwell time) it covers half of the distance to 1.
static void test_breakaway_rises_with_the_time_at_rest(void)
{
    rig_set(&rig, "sliding_ratio", 0.7);
    const double share   = 1.0 / 101.0;
    const double times[] = {0.1, 1.0, 10.0, 100.0};
    for (unsigned i = 0; i < 4; i++)
    {
        const double rise = times[i] + 0.03; // the motion back and to breakaway counts as rest
        const double s    = share + (1.0 - share) * rise / (rise + 1.0);
        const double seen = breakaway_after(times[i]);
        printf("after %g s: %.4f N\n", times[i], seen);
        TEST_ASSERT_DOUBLE_WITHIN(0.01 * L, L * (0.7 + 0.3 * s), seen);
    }
}

static void test_steady_friction_follows_the_stribeck_curve(void)
{
    rig_set(&rig, "sliding_ratio", 0.7);
    rig_set(&rig, "viscous_N_s_per_deg", 0.1);
    rig_slide_start(&slide, &rig, 0.5);
    for (double speed = 0.001; speed < 0.1; speed *= 2.0)
    {
        const double part = speed / 0.01;
        const double f    = L * (0.7 + 0.3 / (1.0 + part * part)) + 0.1 * speed;
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, f, rig_slide_by(&slide, 0.02, speed, 1e-4));
    }
}

/// After a jump of speed the memory covers 1 - 1/e of the distance to the new speed in tl, not at once.
static void test_friction_remembers_speed(void)
{
    rig_set(&rig, "sliding_ratio", 0.7);
    rig_slide_start(&slide, &rig, 0.5);
    const double before = rig_slide_by(&slide, 0.02, 0.001, 1e-4);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * L, before, rig_slide_step(&slide, 0.05, 1e-4));
    for (int i = 1; i < 50; i++)
    {
        (void)rig_slide_step(&slide, 0.05, 1e-4);
    }
    const double memory = (0.001 + 0.049 * (1.0 - exp(-1.0))) / 0.01;
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * L, L * (0.7 + 0.3 / (1.0 + memory * memory)), rig_slide_step(&slide, 0.05, 1e-4));
}

static void test_presliding_is_a_spring_that_does_not_drift(void)
{
    rig_slide_start(&slide, &rig, 0.5);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.1, rig_slide_by(&slide, 5e-4, 1e-3, 1e-4));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.04, rig_slide_by(&slide, -3e-4, 1e-3, 1e-4));
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.0, rig_drift(&rig, 0.1));
}

#include "runners/test_armstrong.inc" // main
