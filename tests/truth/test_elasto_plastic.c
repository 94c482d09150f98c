// Elasto-plastic: elastic, without drift, up to a fraction of breakaway; beyond it like LuGre.

#define TRUTH sim_elasto_plastic_truth
#include "slide_rig.h"

#include <math.h>
#include <stdio.h>

/// Swings of 0.2 to 0.8 of breakaway, below the elastic limit of 0.85.
static void test_it_does_not_drift_in_presliding(void)
{
    const double drift = rig_drift(&rig, 0.1);
    printf("drift in 50 swings: %.2e N\n", drift);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.0, drift);
}

/// With an elastic limit below the same swings, the model becomes LuGre and drifts.
static void test_it_drifts_with_a_low_elastic_limit(void)
{
    rig_set(&rig, "elastic_ratio", 0.0);
    TEST_ASSERT_TRUE(rig_drift(&rig, 0.1) > 1e-3);
}

static void test_presliding_below_the_limit_is_a_spring(void)
{
    rig_slide_start(&slide, &rig, 0.5);
    const double x = 0.8 * L / 200.0;
    // During motion the bristle damping adds 0.3 w.
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 200.0 * x + 0.3 * 1e-3, rig_slide_by(&slide, x, 1e-3, 1e-4));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 200.0 * 0.25 * x - 0.3 * 1e-3, rig_slide_by(&slide, -0.75 * x, 1e-3, 1e-4));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, rig_slide_by(&slide, -0.25 * x, 1e-3, 1e-4) + 0.3 * 1e-3);
}

static void test_sliding_follows_the_stribeck_curve(void)
{
    rig_set(&rig, "sliding_ratio", 0.7);
    rig_slide_start(&slide, &rig, 0.5);
    for (double speed = 0.001; speed < 0.1; speed *= 2.0)
    {
        const double part = speed / 0.01;
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 * L,
                                  L * (0.7 + 0.3 * exp(-part * part)),
                                  rig_slide_by(&slide, 0.02, speed, 1e-4));
    }
}

#include "runners/test_elasto_plastic.inc" // main
