// LuGre: Stribeck effect, friction lag, a breakaway that falls with the rate of force, drift; with the paper's
// parameters no gradual transition.

#define TRUTH sim_lugre_truth
#include "slide_rig.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>

/// The bristle stiffness of this folder's other models, for visible presliding.
static void soften(void)
{
    rig_set(&rig, "stiffness_N_per_deg", 200.0);
    rig_set(&rig, "bristle_damping_N_s_per_deg", 0.3);
    rig_set(&rig, "viscous_N_s_per_deg", 0.0);
}

static void test_steady_friction_follows_the_stribeck_curve(void)
{
    soften();
    rig_set(&rig, "sliding_ratio", 0.7);
    rig_slide_start(&slide, &rig, 0.5);
    for (double speed = 0.001; speed < 0.1; speed *= 2.0)
    {
        const double part = speed / 0.01;
        const double g    = L * (0.7 + 0.3 * exp(-part * part));
        TEST_ASSERT_DOUBLE_WITHIN(1e-4 * L, g, rig_slide_by(&slide, 0.01, speed, 1e-4));
        TEST_ASSERT_DOUBLE_WITHIN(1e-4 * L, -g, rig_slide_by(&slide, -0.01, speed, 1e-4));
    }
}

/// The speed rises and falls between 0.002 and 0.02 deg/s; friction lags, so it is higher during the rise.
static void test_friction_lags_speed(void)
{
    soften();
    rig_set(&rig, "sliding_ratio", 0.7);
    rig_slide_start(&slide, &rig, 0.5);
    (void)rig_slide_by(&slide, 0.01, 0.002, 1e-4);
    const int steps = 500; // 0.05 s each way
    double    up    = 0.0;
    double    down  = 0.0;
    for (int i = 0; i < 2 * steps; i++)
    {
        const int    k     = i < steps ? i : 2 * steps - i;
        const double speed = 0.002 + 0.018 * k / steps;
        const double f     = rig_slide_step(&slide, speed, 1e-4);
        up                 = i == steps / 2 ? f : up;
        down               = i == steps + steps / 2 ? f : down;
    }
    printf("at 0.011 deg/s: up %.4f N, down %.4f N\n", up, down);
    TEST_ASSERT_TRUE(up > down + 0.02 * L);
}

static void find_highest(void *context, const rig_sample_t *sample)
{
    *(double *)context = fmax(*(double *)context, sample->f_n);
}

/// Highest friction while u rises from rest within `seconds`.
static double breakaway(double seconds)
{
    const rig_ramp_t ramps[] = {{0.3, seconds}};
    double           highest = 0.0;
    rig_run(&rig, RIG_STEP_S, ramps, 1, find_highest, &highest);
    return highest;
}

static void test_breakaway_falls_with_the_rate_of_force(void)
{
    soften();
    rig_set(&rig, "sliding_ratio", 0.7);
    rig_constant_breakaway(&rig, 0.1);
    const double slow = breakaway(30.0);
    const double fast = breakaway(1.0);
    printf("breakaway at 0.01 and 0.3 N/s: %.4f, %.4f N\n", slow, fast);
    TEST_ASSERT_TRUE(fast < 0.97 * slow);
    TEST_ASSERT_TRUE(slow < 0.1 + 1e-9);
}

static void test_it_drifts_in_presliding(void)
{
    soften();
    const double drift = rig_drift(&rig, 0.1);
    printf("drift in 50 swings: %.4f N\n", drift);
    TEST_ASSERT_TRUE(drift > 1e-3);
}

/// Fig. 8: after a deep fall the paper's own model lifts F by 5 mN before it breaks away.
static void test_with_the_papers_parameters_no_transition_is_gradual(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(5e-5, 0.0, rig_lift(&rig, 0.12, 1.0));
}

static void test_without_its_limit_viscous_friction_adds_to_breakaway(void)
{
    rig_slide_start(&slide, &rig, 0.5);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, L, rig_slide_by(&slide, 0.01, 0.1, 1e-4));
    rig_slide_end(&slide);
    rig_set(&rig, "limited", 0.0);
    rig_slide_start(&slide, &rig, 0.5);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, L + 0.4 * 0.1, rig_slide_by(&slide, 0.01, 0.1, 1e-4));
}

static void test_bristles_that_stiffen_need_the_same_way_at_each_load(void)
{
    soften();
    rig_set(&rig, "bristle_damping_N_s_per_deg", 0.0);
    TEST_ASSERT_TRUE(rig_part_after(&rig, 2e-4, 0.2) > 1.3 * rig_part_after(&rig, 2e-4, 0.5));
    rig_set(&rig, "stiffens", 1.0);
    const double part = rig_part_after(&rig, 2e-3, 0.5);
    printf("after 0.002 deg: %.3f of L\n", part);
    TEST_ASSERT_TRUE(part > 0.1 && part < 0.9);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, part, rig_part_after(&rig, 2e-3, 0.2));
}

static void see_finite(void *context, const rig_sample_t *sample)
{
    *(bool *)context = *(bool *)context && isfinite(sample->force_n) && isfinite(sample->f_n);
}

/// The next of a row of numbers from `low` to `high`, evenly in their logarithms.
static double drawn(uint32_t *row, double low, double high)
{
    *row = *row * UINT32_C(1664525) + UINT32_C(1013904223);
    return low * pow(high / low, (double)*row / 4294967296.0);
}

/// Bristles bent beyond a breakaway that fell with F give way to speed: friction falls from rest on, and the step's speed is
/// beyond that with the friction of rest.
static void test_bristles_that_are_bent_too_far_are_solved_as_well(void)
{
    uint32_t row    = 1;
    bool     finite = true;
    rig_set(&rig, "viscous_N_s_per_deg", 0.0);
    rig_set(&rig, "limited", 0.0);
    for (int i = 0; i < 100; i++)
    {
        const double damping  = drawn(&row, 1e-5, 0.05);
        const double inertia  = damping * damping * drawn(&row, 1e-3, 20.0);
        const double softness = 60.0 / drawn(&row, 0.1, 50.0);
        const double high_n   = drawn(&row, 100.0, 1000.0);
        rig.config.arm        = (common_arm_config_t){.inertia = inertia, .damping = damping, .stiffness = 1.0};
        rig.config.friction.breakaway.offset_n = drawn(&row, 1.0, 60.0);
        rig.config.friction.breakaway.slope    = drawn(&row, 0.05, 0.9);
        rig_set(&rig, "stiffness_N_per_deg", softness);
        rig_set(&rig, "bristle_damping_N_s_per_deg", sqrt(inertia * softness));
        const rig_ramp_t ramps[] = {{high_n, 0.3},
                                    {0.15 * high_n, 0.01},
                                    {0.15 * high_n, 0.3},
                                    {high_n, 0.01},
                                    {high_n, 0.3}};
        rig_run(&rig, 2.5 * RIG_STEP_S, ramps, sizeof ramps / sizeof ramps[0], see_finite, &finite);
        TEST_ASSERT_TRUE(finite);
    }
}

#include "runners/test_lugre.inc" // main
