// Bristles: noisy sliding friction around L(F), equal along the same path at any speed, different with another seed.

#include "rig.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>

static rig_t       rig;
static rig_slide_t slide;

void setUp(void)
{
    rig_init(&rig, &sim_bristle_truth);
    rig_set(&rig, "sliding_ratio", 1.0);
}

void tearDown(void)
{
    rig_slide_end(&slide);
}

#define L 0.157

typedef struct
{
    double mean_n, deviation_n, last_n;
} noise_t;

static noise_t go(double speed, double step_s)
{
    rig_set(&rig, "damping_N_s_per_deg", 0.0);
    rig_slide_start(&slide, &rig, 0.5);
    (void)rig_slide_by(&slide, 0.01, speed, step_s);
    const int count  = 200000; // 0.2 deg: some 300 snaps of each bristle
    double    sum    = 0.0;
    double    square = 0.0;
    for (int i = 0; i < count; i++)
    {
        const double f = rig_slide_step(&slide, speed, step_s);
        sum += f;
        square += f * f;
    }
    const noise_t noise = {sum / count, sqrt(square / count - sum / count * (sum / count)), slide.f_n};
    rig_slide_end(&slide);
    return noise;
}

/// A bond's deflection over a long path has mean 2/3 d and mean square 1/2 d^2, the average of (1 - u^3) / 3 over (1 - u).
/// Hence 20 of them deviate by 1.5 L sqrt((1/2 - 4/9) / 20) = 0.079 L.
static void test_sliding_is_noisy_about_breakaway(void)
{
    const noise_t noise = go(0.01, 1e-4);
    printf("mean %.4f N, deviation %.4f N\n", noise.mean_n, noise.deviation_n);
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * L, L, noise.mean_n);
    TEST_ASSERT_DOUBLE_WITHIN(0.2 * 0.079 * L, 0.079 * L, noise.deviation_n);
}

static void test_it_is_rate_independent_without_damping(void)
{
    const noise_t slow = go(0.001, 1e-3);
    const noise_t fast = go(1.0, 1e-6);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, slow.last_n, fast.last_n);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, slow.mean_n, fast.mean_n);
}

static void test_another_seed_is_another_noise(void)
{
    const noise_t one = go(0.01, 1e-4);
    rig_set(&rig, "seed", 2.0);
    const noise_t two = go(0.01, 1e-4);
    TEST_ASSERT_TRUE(fabs(one.last_n - two.last_n) > 1e-4);
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * L, L, two.mean_n);
}

/// From rest the first bond snaps after a tenth of d; below that all are springs.
static void test_small_presliding_is_a_spring(void)
{
    rig_slide_start(&slide, &rig, 0.5);
    const double k = 1.5 * L / 1.2e-3;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, k * 5e-5 + 0.3 * 1e-3, rig_slide_by(&slide, 5e-5, 1e-3, 1e-4));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, -0.3 * 1e-3, rig_slide_by(&slide, -5e-5, 1e-3, 1e-4));
}

#include "runners/test_bristle.inc" // main
