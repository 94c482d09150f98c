// Not a test: research/bench-compensation runs it for what tribo-sim does not play.
//
//     build/host-release/tests/closed_loop/compensation_study_f32 environment    it moves while r rests
//     build/host-release/tests/closed_loop/compensation_study_f32 learned        how far the learned breakaway is off

#include "compensation.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const compensation_triangle_t benchmark = {0.4, 0.6, 0.02};

/// One period of the benchmark, then 0.5 N, reached from below at its slope, and held.
static double ramp_and_hold(const void *context, double t)
{
    (void)context;
    return t < 20.0 ? compensation_triangle(&benchmark, t) : fmin(0.5, 0.4 + 0.02 * (t - 20.0));
}

static void three(const char *name, const compensation_truth_t *truth)
{
    const compensation_result_t off = compensation_run(COMPENSATION_OFF, NULL, truth, ramp_and_hold, NULL, 30.0, 40.0);
    const compensation_result_t paper =
        compensation_run(COMPENSATION_PAPER, NULL, truth, ramp_and_hold, NULL, 30.0, 40.0);
    const compensation_result_t x =
        compensation_run(COMPENSATION_FEEDFORWARD, NULL, truth, ramp_and_hold, NULL, 30.0, 40.0);
    printf("%-30s off %.3f mN, paper %.3f (%.2f times), feed-forward %.3f (%.2f times), "
           "peak %.2f mN\n",
           name,
           1e3 * off.rms,
           1e3 * paper.rms,
           off.rms / paper.rms,
           1e3 * x.rms,
           off.rms / x.rms,
           1e3 * x.peak);
    (void)fflush(stdout);
}

static void study_environment(void)
{
    static const double scale[] = {1.0, 0.9, 0.5};
    for (int i = 0; i < 6; i++)
    {
        compensation_truth_t truth = compensation_nominal();
        char                 name[64];
        truth.breakaway_positive = scale[i / 2];
        truth.breakaway_negative = scale[i / 2];
        truth.environment_hz     = i % 2 == 0 ? 0.1 : 1.0;
        truth.environment_n      = 0.05;
        (void)snprintf(name, sizeof name, "environment %.1f Hz, br. %.1f", truth.environment_hz, scale[i / 2]);
        three(name, &truth);
    }
}

/// The error of L after four reversals, from a prior 30 % too large or too small. A slide does not need the truth's L: an arm
/// that falls slowly under noise stays on the curve below it.
static void study_learned(void)
{
    static const double scale[]    = {0.7, 1.3};
    static const double noise_mn[] = {0.0, 0.3, 1.0};
    for (int i = 0; i < 6; i++)
    {
        compensation_truth_t truth = compensation_nominal();
        truth.breakaway_positive   = scale[i % 2];
        truth.breakaway_negative   = scale[i % 2];
        truth.noise_n              = 1e-3 * noise_mn[i / 2];
        const compensation_result_t x =
            compensation_run(COMPENSATION_FEEDFORWARD, NULL, &truth, compensation_triangle, &benchmark, 40.0, 20.0);
        printf("learned L, breakaway %.1f, %.1f mN of noise: %.1f %% off the friction of slides, up to %.1f %% off the "
               "truth's L\n",
               scale[i % 2],
               noise_mn[i / 2],
               1e2 * x.friction_off,
               1e2 * x.breakaway_off);
    }
}

int main(int argc, char **argv)
{
    UNITY_BEGIN(); // for the asserts of the rig
    if (argc > 1 && strcmp(argv[1], "learned") == 0)
    {
        study_learned();
    }
    else
    {
        study_environment();
    }
    return 0;
}
