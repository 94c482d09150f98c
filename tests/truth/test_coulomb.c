// Coulomb: stands exactly inside breakaway, slides with L(F) at any speed, has no memory.

#include "rig.h"
#include "unity.h"

#include <math.h>

static rig_t rig;

void setUp(void)
{
    rig_init(&rig, &sim_coulomb_truth);
}

static void test_it_stands_to_the_last_bit_inside_breakaway(void)
{
    TEST_ASSERT_TRUE(rig_drift(&rig, 0.1) == 0.0);
}

static void test_it_breaks_away_at_breakaway_in_both_directions(void)
{
    // From F = 0 breakaway is 0.007 N.
    const rig_ramp_t ramps[] = {{0.0069, 1.0}, {-0.0069, 2.0}, {-0.0171, 1.0}, {-0.0171, 0.2}, {0.0051, 1.0}};
    double           forces[5];
    rig_forces(&rig, ramps, 5, forces);
    TEST_ASSERT_TRUE(forces[0] == 0.0 && forces[1] == 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, -0.0101 / 1.3, forces[3]);
    // At -0.0078 N breakaway is 0.0093 N. At u = 0.0051 N n is 0.0128 N: it has moved.
    TEST_ASSERT_TRUE(forces[4] > forces[3] + 1e-3);
}

static void test_friction_of_sliding_does_not_depend_on_speed(void)
{
    rig_slide_t slide;
    rig_slide_start(&slide, &rig, 0.5);
    for (double speed = 1e-4; speed < 100.0; speed *= 10.0)
    {
        TEST_ASSERT_DOUBLE_WITHIN(1e-15, 0.157, rig_slide_step(&slide, speed, RIG_STEP_S));
        TEST_ASSERT_DOUBLE_WITHIN(1e-15, -0.157, rig_slide_step(&slide, -speed, RIG_STEP_S));
    }
    rig_slide_end(&slide);
}

/// F where breakaway ends stays, as L is that of rest; then friction is that of the speed.
static void test_friction_of_sliding_may_fall_with_speed(void)
{
    const rig_ramp_t up[] = {{0.0069, 1.0}};
    double           force;
    rig_set(&rig, "sliding_ratio", 0.7);
    rig_forces(&rig, up, 1, &force);
    TEST_ASSERT_TRUE(force == 0.0);
    rig_slide_t slide;
    rig_slide_start(&slide, &rig, 0.5);
    for (double speed = 0.001; speed < 0.1; speed *= 2.0)
    {
        const double part = speed / 0.01;
        TEST_ASSERT_DOUBLE_WITHIN(1e-12,
                                  0.157 * (0.7 + 0.3 * exp(-part * part)),
                                  rig_slide_by(&slide, 10 * speed, speed, 0.1));
    }
    rig_slide_end(&slide);
}

#include "runners/test_coulomb.inc" // main
