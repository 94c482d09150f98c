// Prints tables that compare the compensation methods. Not a test; run it by hand:
//
//     build/host-release/tests/closed_loop/compensation_study_f32 [triangle|many|...]
//
// research/bench-compensation measures more, on tribo-sim; only this study moves the environment and judges the learned values.

#include "compensation.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void print(const char *name, compensation_result_t x, compensation_result_t off)
{
    printf("%-32s RMS %.6f N (%5.2f times), peak %.2f mN, TV %.3f N (%.3f), first %.6f (%.2f), peak %.2f mN\n",
           name,
           x.rms,
           off.rms / x.rms,
           1e3 * x.peak,
           x.variation,
           x.variation / off.variation,
           x.first_rms,
           off.first_rms / x.first_rms,
           1e3 * x.first_peak);
}

static const compensation_triangle_t benchmark = {0.4, 0.6, 0.02};

static void study_triangle(void)
{
    const compensation_truth_t     truth  = compensation_nominal();
    tribo_feedforward_f32_config_t config = tribo_feedforward_f32_default();

    const compensation_result_t off = compensation_run_triangle(COMPENSATION_OFF, NULL, &truth, benchmark);
    print("off", off, off);
    print("paper", compensation_run_triangle(COMPENSATION_PAPER, NULL, &truth, benchmark), off);
    print("feed-forward", compensation_run_triangle(COMPENSATION_FEEDFORWARD, NULL, &truth, benchmark), off);
    config.jump_lead = 0.0f;
    print("feed-forward, jump lead 0",
          compensation_run_triangle(COMPENSATION_FEEDFORWARD, &config, &truth, benchmark),
          off);
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

/// The 32 triangles under one truth: the least and median ratio, the least in the first period, the largest variation.
static void study_many(const char *name, compensation_t method, compensation_truth_t truth)
{
    static const double range[8][2] =
        {{0.1, 0.3}, {0.2, 0.5}, {0.2, 0.6}, {0.3, 0.5}, {0.4, 0.6}, {0.1, 0.5}, {-0.2, 0.2}, {-0.4, 0.4}};
    static const double slope[4] = {0.01, 0.015, 0.02, 0.04};
    double              ratio[32];
    double              first     = (double)INFINITY;
    double              variation = 0.0;
    for (int i = 0; i < 32; i++)
    {
        const compensation_triangle_t triangle = {range[i / 4][0], range[i / 4][1], slope[i % 4]};
        const compensation_result_t   off      = compensation_run_triangle(COMPENSATION_OFF, NULL, &truth, triangle);
        const compensation_result_t   x        = compensation_run_triangle(method, NULL, &truth, triangle);
        ratio[i]                               = off.rms / x.rms;
        first                                  = fmin(first, off.first_rms / x.first_rms);
        variation                              = fmax(variation, x.variation / off.variation);
        if (getenv("VERBOSE") != NULL)
        {
            printf("  %g to %g at %g: ratio %.2f, peak %.2f mN, variation %.3f, first %.2f\n",
                   triangle.low,
                   triangle.high,
                   triangle.slope,
                   ratio[i],
                   1e3 * x.peak,
                   x.variation / off.variation,
                   off.first_rms / x.first_rms);
        }
    }
    qsort(ratio, 32, sizeof ratio[0], ascending);
    printf("%-42s least %.2f median %.2f, first period least %.2f, TV most %.3f\n",
           name,
           ratio[0],
           0.5 * (ratio[15] + ratio[16]),
           first,
           variation);
    (void)fflush(stdout);
}

static void study_breakaway(double noise)
{
    static const double scale[] = {1.0, 0.8, 1.2, 0.5, 1.5};
    for (int i = 0; i < 5; i++)
    {
        compensation_truth_t truth = compensation_nominal();
        char                 name[64];
        truth.breakaway_positive = scale[i];
        truth.breakaway_negative = scale[i];
        truth.noise_n            = noise;
        (void)snprintf(name, sizeof name, "paper, breakaway %.1f, noise %.0f mN", scale[i], 1e3 * noise);
        study_many(name, COMPENSATION_PAPER, truth);
        (void)snprintf(name, sizeof name, "feed-forward, breakaway %.1f, noise %.0f mN", scale[i], 1e3 * noise);
        study_many(name, COMPENSATION_FEEDFORWARD, truth);
    }
}

static void study_variants(void)
{
    static const struct
    {
        const char *name;
        double      stiffness, gain, delay, quantisation;
    } variant[] = {{"delay 1 ms", 1.0, 1.0, 1e-3, 0.0},
                   {"delay 3 ms", 1.0, 1.0, 3e-3, 0.0},
                   {"stiffness 0.5", 0.5, 1.0, 0.0, 0.0},
                   {"stiffness 1.5", 1.5, 1.0, 0.0, 0.0},
                   {"12 bit of +-2 N", 1.0, 1.0, 0.0, 4.0 / 4096.0},
                   {"actuator gain 0.86", 1.0, 0.86, 0.0, 0.0}};
    for (size_t i = 0; i < sizeof variant / sizeof variant[0]; i++)
    {
        compensation_truth_t truth      = compensation_nominal();
        truth.stiffness                 = variant[i].stiffness;
        truth.actuator_gain             = variant[i].gain;
        truth.delay_s                   = variant[i].delay;
        truth.quantisation_n            = variant[i].quantisation;
        const compensation_result_t off = compensation_run_triangle(COMPENSATION_OFF, NULL, &truth, benchmark);
        char                        name[64];
        (void)snprintf(name, sizeof name, "paper, %s", variant[i].name);
        print(name, compensation_run_triangle(COMPENSATION_PAPER, NULL, &truth, benchmark), off);
        (void)snprintf(name, sizeof name, "feed-forward, %s", variant[i].name);
        print(name, compensation_run_triangle(COMPENSATION_FEEDFORWARD, NULL, &truth, benchmark), off);
    }
}

/// A square wave from its low end.
typedef struct
{
    double low, high, period_s;
} square_t;

static double square(const void *context, double t)
{
    const square_t *wave = context;
    return fmod(t, wave->period_s) < 0.5 * wave->period_s ? wave->low : wave->high;
}

/// One period of the benchmark, then 0.5 N, reached from below at its slope, and held.
static double ramp_and_hold(const void *context, double t)
{
    (void)context;
    return t < 20.0 ? compensation_triangle(&benchmark, t) : fmin(0.5, 0.4 + 0.02 * (t - 20.0));
}

static void three(const char                 *name,
                  const compensation_truth_t *truth,
                  compensation_reference_t    reference,
                  const void                 *context,
                  double                      first_s,
                  double                      second_s)
{
    const compensation_result_t off =
        compensation_run(COMPENSATION_OFF, NULL, truth, reference, context, first_s, second_s);
    const compensation_result_t paper =
        compensation_run(COMPENSATION_PAPER, NULL, truth, reference, context, first_s, second_s);
    const compensation_result_t x =
        compensation_run(COMPENSATION_FEEDFORWARD, NULL, truth, reference, context, first_s, second_s);
    printf("%-30s off %.3f mN, paper %.3f (%.2f times), feed-forward %.3f (%.2f times), "
           "peak %.2f mN, TV %.3f N (%.2f)\n",
           name,
           1e3 * off.rms,
           1e3 * paper.rms,
           off.rms / paper.rms,
           1e3 * x.rms,
           off.rms / x.rms,
           1e3 * x.peak,
           x.variation,
           x.variation / off.variation);
    (void)fflush(stdout);
}

static void study_steps(void)
{
    static const double scale[] = {1.0, 0.5, 0.8, 1.2, 1.5};
    for (int i = 0; i < 5; i++)
    {
        compensation_truth_t truth = compensation_nominal();
        const square_t       large = {0.4, 0.6, 10.0};
        const square_t       small = {0.4, 0.42, 10.0};
        char                 name[64];
        truth.breakaway_positive = scale[i];
        truth.breakaway_negative = scale[i];
        (void)snprintf(name, sizeof name, "steps 0.4/0.6, breakaway %.1f", scale[i]);
        three(name, &truth, square, &large, 10.0, 20.0);
        (void)snprintf(name, sizeof name, "steps 0.4/0.42, breakaway %.1f", scale[i]);
        three(name, &truth, square, &small, 10.0, 20.0);
    }
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
        three(name, &truth, ramp_and_hold, NULL, 30.0, 40.0);
    }
}

static void study_hold(void)
{
    for (int i = 0; i < 6; i++)
    {
        compensation_truth_t truth = compensation_nominal();
        char                 name[64];
        truth.noise_n    = i > 0 ? 1e-3 : 0.0;
        truth.noise_seed = (uint64_t)i;
        (void)snprintf(name, sizeof name, "hold, noise %.0f mN, seed %d", 1e3 * truth.noise_n, i);
        three(name, &truth, ramp_and_hold, NULL, 30.0, 30.0);
    }
}

static void study_long_hold(void)
{
    static const double noise[] = {0.0, 0.3e-3, 1e-3};
    for (int i = 0; i < 3; i++)
    {
        compensation_truth_t truth = compensation_nominal();
        char                 name[64];
        truth.noise_n = noise[i];
        (void)snprintf(name, sizeof name, "hold of 5 min, noise %.1f mN", 1e3 * noise[i]);
        three(name, &truth, ramp_and_hold, NULL, 40.0, 300.0);
    }
}

/// 0.5 N and 0.1 N of a sine.
static double sine(const void *context, double t)
{
    const double *hz = context;
    return 0.5 + 0.1 * sin(6.283185307179586 * *hz * t);
}

static void study_sines(void)
{
    static const double hz[] = {0.05, 0.1, 0.2, 0.5, 1.0};
    for (int i = 0; i < 5; i++)
    {
        const compensation_truth_t truth = compensation_nominal();
        char                       name[64];
        (void)snprintf(name, sizeof name, "sine of %.2f Hz", hz[i]);
        three(name, &truth, sine, &hz[i], 1.0 / hz[i], fmax(2.0 / hz[i], 10.0));
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

static bool wanted(int argc, char **argv, const char *name)
{
    bool found = argc < 2;
    for (int i = 1; i < argc; i++)
    {
        found = found || strcmp(argv[i], name) == 0;
    }
    return found;
}

int main(int argc, char **argv)
{
    UNITY_BEGIN(); // for the asserts of the rig
    if (wanted(argc, argv, "triangle"))
    {
        study_triangle();
    }
    if (wanted(argc, argv, "variants"))
    {
        study_variants();
    }
    if (wanted(argc, argv, "steps"))
    {
        study_steps();
    }
    if (wanted(argc, argv, "environment"))
    {
        study_environment();
    }
    if (wanted(argc, argv, "hold"))
    {
        study_hold();
    }
    if (wanted(argc, argv, "long"))
    {
        study_long_hold();
    }
    if (wanted(argc, argv, "learned"))
    {
        study_learned();
    }
    if (wanted(argc, argv, "sines"))
    {
        study_sines();
    }
    if (wanted(argc, argv, "many"))
    {
        study_breakaway(0.0);
    }
    if (wanted(argc, argv, "noise"))
    {
        study_breakaway(1e-3);
    }
    return 0;
}
