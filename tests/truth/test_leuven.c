// Leuven: presliding hysteresis with non-local memory, and LuGre's sliding.

#define TRUTH sim_leuven_truth
#include "slide_rig.h"

#include <math.h>
#include <stdio.h>

static void test_an_inner_loop_closes_and_is_forgotten(void)
{
    rig_set(&rig, "exponent", 20.0); // presliding is then pure hysteresis
    rig_set(&rig, "bristle_damping_N_s_per_deg", 0.0);
    const double leuven = rig_inner_loop(&rig);
    rig_init(&rig, &sim_dahl_truth);
    TEST_ASSERT_TRUE(leuven < 0.1 * rig_inner_loop(&rig));
    TEST_ASSERT_TRUE(leuven < 1e-3 * L);
}

/// Elements yield at 2.0e-4, 5.3e-4, 1.2e-3 deg: the slope falls in steps. Far from sliding z is x.
static void test_presliding_starts_with_the_stiffness_of_all_elements(void)
{
    rig_set(&rig, "exponent", 20.0);
    rig_set(&rig, "bristle_damping_N_s_per_deg", 0.0);
    rig_slide_start(&slide, &rig, 0.5);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * L, L / 8e-4 * 1.5e-4, rig_slide_by(&slide, 1.5e-4, 1e-3, 1e-4));
    const double x = 4e-4;
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * L, L * (0.1 + 0.6 * x / 8e-4), rig_slide_by(&slide, x - 1.5e-4, 1e-3, 1e-4));
}

static void test_steady_friction_follows_the_stribeck_curve(void)
{
    rig_set(&rig, "sliding_ratio", 0.7);
    rig_set(&rig, "viscous_N_s_per_deg", 0.1);
    rig_slide_start(&slide, &rig, 0.5);
    for (double speed = 0.001; speed < 0.1; speed *= 2.0)
    {
        const double part = speed / 0.01;
        const double f    = L * (0.7 + 0.3 * exp(-part * part)) + 0.1 * speed;
        TEST_ASSERT_DOUBLE_WITHIN(2e-3 * L, f, rig_slide_by(&slide, 0.05, speed, 1e-4));
    }
}

/// The yielding bristle makes the arm creep, less with a sharper onset of sliding.
static void test_drift_falls_with_the_exponent(void)
{
    rig_set(&rig, "exponent", 1.0);
    const double blunt = rig_drift(&rig, 0.1);
    rig_set(&rig, "exponent", 20.0);
    const double sharp = rig_drift(&rig, 0.1);
    printf("drift in 50 swings: %.5f and %.5f N\n", blunt, sharp);
    TEST_ASSERT_TRUE(fabs(sharp) < 0.1 * fabs(blunt));
}

#include "runners/test_leuven.inc" // main
