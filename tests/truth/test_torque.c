// The torque-based model: friction equals the net force up to breakaway, so the transition is sharp and nothing drifts.

#include "rig.h"
#include "unity.h"

#include <math.h>

static rig_t rig;

void setUp(void)
{
    rig_init(&rig, &sim_torque_truth);
}

static void test_it_does_not_drift_in_presliding(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, rig_drift(&rig, 0.1));
}

/// After a fall to 0.12 N, which lifts F by 2.6 mN in the paper's model (tests/closed_loop/test_open_loop.c).
static void test_a_rise_after_a_deep_fall_does_not_lift_the_force_before_breakaway(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, rig_lift(&rig, 0.12, 1.0));
}

/// u = F + L(F) while the arm slides slowly, except for its damping b F'/K.
static void test_sliding_friction_is_breakaway_of_the_load(void)
{
    const rig_ramp_t ramps[] = {{0.6, 6.0}};
    double           force;
    rig_forces(&rig, ramps, 1, &force);
    const double rate = 0.1 / 1.3;
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.6 - 0.0288 * rate / 3.84, force + 0.007 + 0.3 * force);
}

#include "runners/test_torque.inc" // main
