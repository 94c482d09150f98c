// Karnopp: inside a zone of speeds the position stands exactly; breakaway may exceed sliding friction.

#include "rig.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>

static rig_t rig;

void setUp(void)
{
    rig_init(&rig, &sim_karnopp_truth);
}

static void test_it_stands_to_the_last_bit_inside_breakaway(void)
{
    TEST_ASSERT_TRUE(rig_drift(&rig, 0.1) == 0.0);
}

static void find_slowest(void *context, const rig_sample_t *sample)
{
    double      *slowest = context;
    const double speed   = fabs(sample->speed_deg_per_s);
    if (speed > 0.0)
    {
        *slowest = fmin(*slowest, speed);
    }
}

static void test_no_motion_is_slower_than_the_dead_zone(void)
{
    const rig_ramp_t ramps[] = {{0.3, 3.0}, {0.3, 0.5}, {0.1, 2.0}, {0.1, 0.5}};
    double           slowest = 1.0;
    rig_run(&rig, RIG_STEP_S, ramps, 4, find_slowest, &slowest);
    // The steps at stop and start are shortened by up to the zone; the arm's own speed is 0.02 deg/s.
    TEST_ASSERT_TRUE(slowest < 0.01);
    TEST_ASSERT_TRUE(slowest > 0.4 * 2e-4);
}

typedef struct
{
    double past_n, largest_jump_n, since_n, stood_s;
} jumps_t;

static void find_jumps(void *context, const rig_sample_t *sample)
{
    jumps_t *jumps = context;
    if (sample->force_n == jumps->past_n)
    {
        jumps->since_n = sample->force_n;
        jumps->stood_s += RIG_STEP_S;
    }
    jumps->largest_jump_n = fmax(jumps->largest_jump_n, fabs(sample->force_n - jumps->since_n));
    jumps->past_n         = sample->force_n;
}

/// With breakaway above sliding friction a slow rise moves the arm in jumps. On the spring it overshoots the balance by its
/// deficit before, reduced by damping: from (1 - r) L to 2 (1 - r) L.
static void test_a_slow_rise_goes_in_jumps_when_breakaway_exceeds_sliding(void)
{
    rig_set(&rig, "sliding_ratio", 0.8);
    rig_constant_breakaway(&rig, 0.05);
    jumps_t          jumps  = {0};
    const rig_ramp_t slow[] = {{0.2, 20.0}};
    rig_run(&rig, RIG_STEP_S, slow, 1, find_jumps, &jumps);
    printf("stood for %.2f of 20 s, largest jump %.4f N\n", jumps.stood_s, jumps.largest_jump_n);
    TEST_ASSERT_TRUE(jumps.stood_s > 15.0);
    TEST_ASSERT_TRUE(jumps.largest_jump_n > 0.2 * 0.05);
    TEST_ASSERT_TRUE(jumps.largest_jump_n < 2.0 * 0.2 * 0.05);

    rig_set(&rig, "sliding_ratio", 1.0);
    jumps = (jumps_t){0};
    rig_run(&rig, RIG_STEP_S, slow, 1, find_jumps, &jumps);
    TEST_ASSERT_TRUE(jumps.stood_s < 6.0); // to breakaway, 0.05 N at 0.01 N/s
}

#include "runners/test_karnopp.inc" // main
