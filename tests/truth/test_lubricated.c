// Lubricated contact: breakaway L at rest; with speed a film takes over the load, with a lag.

#define TRUTH sim_lubricated_truth
#include "slide_rig.h"

#include <math.h>
#include <stdio.h>

/// Friction at the film's balance: contact + lift = L, lift = c w e^2 / (1 - e^2)^2.
static double steady(double speed)
{
    double low  = 0.0;
    double high = 0.999;
    for (int i = 0; i < 100; i++)
    {
        const double e       = 0.5 * (low + high);
        const double gap     = 1.0 - e * e;
        const double carried = 20.0 * fmax(0.0, e - 0.7) + 0.2 * speed * e * e / (gap * gap);
        low                  = carried < L ? e : low;
        high                 = carried < L ? high : e;
    }
    return 20.0 * fmax(0.0, low - 0.7) + 0.01 * speed / sqrt(1.0 - low * low);
}

static void test_steady_friction_falls_with_speed_and_rises_with_the_film(void)
{
    rig_slide_start(&slide, &rig, 0.5);
    double past = 1.0;
    for (double speed = 0.003; speed < 0.3; speed *= 2.0)
    {
        const double f = rig_slide_by(&slide, speed * 5.0, speed, 1e-3);
        printf("%.3f deg/s: %.5f N\n", speed, f);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 * L, steady(speed), f);
        TEST_ASSERT_TRUE(f < past);
        past = f;
    }
    // The film carries the whole load.
    const double fast = rig_slide_by(&slide, 20.0, 4.0, 1e-3);
    TEST_ASSERT_TRUE(rig_slide_by(&slide, 40.0, 8.0, 1e-3) > 1.5 * fast);
}

static void test_breakaway_from_rest_is_that_of_the_load(void)
{
    rig_slide_start(&slide, &rig, 0.5);
    for (int i = 0; i < 5000; i++)
    {
        (void)rig_slide_step(&slide, 0.0, 1e-3); // the load comes from 0
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * L, L, rig_slide_by(&slide, 0.01, 0.001, 1e-4));
}

/// 0.02 deg/s to 0.2 and back in 0.2 s each: friction on the way up is higher.
static void test_friction_remembers_speed(void)
{
    rig_slide_start(&slide, &rig, 0.5);
    (void)rig_slide_by(&slide, 0.1, 0.02, 1e-3);
    double up   = 0.0;
    double down = 0.0;
    for (int i = 0; i < 400; i++)
    {
        const double f = rig_slide_step(&slide, 0.02 + 0.18 * (i < 200 ? i : 400 - i) / 200.0, 1e-3);
        up             = i == 100 ? f : up;
        down           = i == 300 ? f : down;
    }
    printf("at 0.11 deg/s: up %.4f N, down %.4f N, steady %.4f N\n", up, down, steady(0.11));
    TEST_ASSERT_TRUE(up > steady(0.11) + 0.05 * L);
    TEST_ASSERT_TRUE(up > down + 0.05 * L);
}

#define INTERVALS 2000

/// The film's integrals over the converging half, by Simpson's rule: J12 and J22 of Harnoy's book.
static void integrals(double e, double *j12, double *j22)
{
    const double pi = acos(-1.0);
    *j12            = 0.0;
    *j22            = 0.0;
    for (int i = 0; i <= INTERVALS; i++)
    {
        const double angle  = pi * i / INTERVALS;
        const double film   = 1.0 + e * cos(angle);
        const double weight = (i == 0 || i == INTERVALS ? 1.0 : i % 2 == 1 ? 4.0 : 2.0) * pi / INTERVALS / 3.0;
        *j12 += weight * sin(angle) * cos(angle) / (film * film * film);
        *j22 += weight * cos(angle) * cos(angle) / (film * film * film);
    }
}

/// Jumps of speed from rest, in both directions: friction 0.05 s later, from the film's balance with these integrals.
static void test_the_film_obeys_its_integrals_in_both_directions(void)
{
    double e = 0.7 + L / 20.0;
    for (int i = 0; i < 50; i++)
    {
        double j12;
        double j22;
        integrals(e, &j12, &j22);
        e += 1e-3 * (L - 20.0 * fmax(0.0, e - 0.7) - 0.2 * 0.3 * e * fabs(j12) / 2.0) / (0.2 * j22);
    }
    const double expected = 20.0 * fmax(0.0, e - 0.7) + 0.01 * 0.3 / sqrt(1.0 - e * e);
    TEST_ASSERT_TRUE(expected < 0.9 * L);
    for (int way = 1; way >= -1; way -= 2)
    {
        rig_slide_start(&slide, &rig, 0.5);
        for (int i = 0; i < 5000; i++)
        {
            (void)rig_slide_step(&slide, 0.0, 1e-3); // the load comes from 0
        }
        for (int i = 0; i < 500; i++)
        {
            (void)rig_slide_step(&slide, way * 0.3, 1e-4);
        }
        TEST_ASSERT_DOUBLE_WITHIN(0.01 * L, way * expected, slide.f_n);
        rig_slide_end(&slide);
    }
}

#include "runners/test_lubricated.inc" // main
