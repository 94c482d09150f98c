// Reset integrator: a spring up to breakaway, then at once the lower slipping friction; no drift.

#define TRUTH sim_reset_integrator_truth
#include "slide_rig.h"

#include <math.h>
#include <stdio.h>

static void test_presliding_is_a_spring_up_to_breakaway_and_then_friction_falls(void)
{
    rig_slide_start(&slide, &rig, 0.5);
    const double damping = 0.3 * 1e-3;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.5 * L + damping, rig_slide_by(&slide, 4e-4, 1e-3, 1e-4));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.99 * L + damping, rig_slide_by(&slide, 3.92e-4, 1e-3, 1e-4));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, L / 1.05, rig_slide_by(&slide, 1e-4, 1e-3, 1e-4));
    for (double speed = 1e-3; speed < 10.0; speed *= 10.0)
    {
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, L / 1.05, rig_slide_by(&slide, 1e-3, speed, 1e-4));
    }
}

static void test_on_the_way_back_the_bond_holds_again_at_once(void)
{
    rig_slide_start(&slide, &rig, 0.5);
    (void)rig_slide_by(&slide, 2e-3, 1e-3, 1e-4);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.5 * L - 0.3 * 1e-3, rig_slide_by(&slide, -4e-4, 1e-3, 1e-4));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, -L / 1.05, rig_slide_by(&slide, -1.3e-3, 1e-3, 1e-4));
}

static void test_it_does_not_drift_in_presliding(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.0, rig_drift(&rig, 0.1));
}

#include "runners/test_reset_integrator.inc" // main
