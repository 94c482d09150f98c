// Bliman and Sorine: a breakaway peak along the path, the same at any speed.

#define TRUTH sim_bliman_sorine_truth
#include "slide_rig.h"

#include <math.h>
#include <stdio.h>

typedef struct
{
    double highest_n, at_deg, last_n;
} path_t;

static path_t go(double speed, double step_s)
{
    path_t path = {0};
    rig_slide_start(&slide, &rig, 0.5);
    while (slide.position_deg < 0.03)
    {
        path.last_n = rig_slide_step(&slide, speed, step_s);
        if (path.last_n > path.highest_n)
        {
            path.highest_n = path.last_n;
            path.at_deg    = slide.position_deg;
        }
    }
    rig_slide_end(&slide);
    return path;
}

/// The peak of (1 - exp(-s / (h e))) - r (1 - exp(-s / e)) is at s = e h / (1 - h) ln(1 / (h r)).
static void test_friction_peaks_at_breakaway_and_falls_along_the_path(void)
{
    const path_t path = go(0.01, 1e-4);
    printf("peak %.5f N at %.2e deg, then %.5f N\n", path.highest_n, path.at_deg, path.last_n);
    TEST_ASSERT_DOUBLE_WITHIN(2e-3 * L, L, path.highest_n);
    const double at = 0.003 * 0.3 / 0.7 * log(1.0 / (0.3 * 0.2));
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * at, at, path.at_deg);
    const double rise = at / (0.3 * 0.003);
    const double peak = 1.0 - exp(-rise) - 0.2 * (1.0 - exp(-at / 0.003));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * L, L * 0.8 / peak, path.last_n);
}

static void test_it_is_rate_independent(void)
{
    const path_t slow = go(0.001, 1e-3);
    const path_t fast = go(1.0, 1e-6);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6 * L, slow.highest_n, fast.highest_n);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6 * L, slow.last_n, fast.last_n);
}

static void test_without_the_slow_part_it_is_dahls(void)
{
    rig_set(&rig, "slow_share", 0.0);
    rig_slide_start(&slide, &rig, 0.5);
    const double x = 4e-4;
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * L, L * (1.0 - exp(-x / (0.3 * 0.003))), rig_slide_by(&slide, x, 0.001, 1e-4));
}

#include "runners/test_bliman_sorine.inc" // main
