// Dahl: the same exponential loop in space at any speed, no Stribeck effect, and drift in presliding.

#define TRUTH sim_dahl_truth
#include "slide_rig.h"

#include <math.h>
#include <stdio.h>

#define S0 200.0

static void test_the_loop_is_exponential_in_position(void)
{
    rig_slide_start(&slide, &rig, 0.5);
    const double up = rig_slide_by(&slide, 5e-4, 0.005, 1e-5);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * L, L * (1.0 - exp(-S0 * 5e-4 / L)), up);
    const double down = rig_slide_by(&slide, -8e-4, 0.005, 1e-5);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * L, -L + (L + up) * exp(-S0 * 8e-4 / L), down);
}

static void test_the_loop_does_not_depend_on_speed(void)
{
    rig_slide_start(&slide, &rig, 0.5);
    (void)rig_slide_by(&slide, 5e-4, 0.001, 1e-5);
    const double slow = rig_slide_by(&slide, -3e-4, 0.001, 1e-5);
    rig_slide_end(&slide);
    rig_slide_start(&slide, &rig, 0.5);
    (void)rig_slide_by(&slide, 5e-4, 1.0, 1e-7);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * L, slow, rig_slide_by(&slide, -3e-4, 1.0, 1e-7));
}

static void test_friction_of_sliding_is_breakaway_at_any_speed(void)
{
    rig_slide_start(&slide, &rig, 0.5);
    for (double speed = 1e-3; speed < 20.0; speed *= 10.0)
    {
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * L, L, rig_slide_by(&slide, 0.02, speed, 1e-4));
    }
}

static void test_it_drifts_in_presliding(void)
{
    const double drift = rig_drift(&rig, 0.1);
    printf("drift in 50 swings: %.4f N\n", drift);
    TEST_ASSERT_TRUE(drift > 1e-3);
}

#include "runners/test_dahl.inc" // main
