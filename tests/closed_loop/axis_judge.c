// Judges a force axis that is made as its header says, with a PI and numbers that a user would have. Arms, frictions and waveforms share
// no code with host_sim. Prints the cases in which compensation gains least, and a summary:
//
//     axis_judge_f32 FIRST LAST    seeds, one axis each
//
// without/with is the RMS of r - F of that PI alone, over that of the axis, in the last two thirds of a run. Exit status 1 if one of them is
// below 0.9, if their median is below 5, or if fewer than 80 of 100 reported intervals hold the breakaway.

#include "foreign_plant.h"

#ifdef TRIBO_ARITHMETIC_Q31
#include "tribo/axis_q31.h"
#define AXIS(verb) tribo_axis_q31_##verb
#else
#include "tribo/axis_f32.h"
#define AXIS(verb) tribo_axis_f32_##verb
#endif

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define SEEDS_MAX 1000
#define SHOWN     5
#define TWO_PI    6.283185307179586

typedef enum
{
    TRIANGLE,
    SINE,
    NESTED,
    STEPS,
    TRAPEZIUM,
    WAVES
} wave_t;

static const char *const wave_names[WAVES]       = {"triangle", "sine", "nested", "steps", "trapezium"};
static const char *const law_names[FOREIGN_LAWS] = {"coulomb", "stribeck", "lugre", "maxwell", "smooth"};

typedef struct
{
    foreign_plant_config_t plant;
    double                 force, period_s, h_s; // N: the usual force
    wave_t                 wave;
    double                 kp, ki_per_s;
    double                 belief[4]; // of breakaway, arm's lag, actuator's and sensor's pole, over the truth
} case_t;

static double uniform(uint64_t *seed, double low, double high)
{
    return low + (high - low) * 0.5 * (foreign_random(seed) + 1.0);
}

static double spread(uint64_t *seed, double low, double high)
{
    return exp(uniform(seed, log(low), log(high)));
}

/// One of 0 to count - 1.
static int pick(uint64_t *seed, int count)
{
    return (int)uniform(seed, 0.0, (double)count - 0.001);
}

/// A PI for the arm without friction: half of the lags but the largest, which the zero cancels, and up to four times slower.
static void tune(case_t *c, uint64_t *seed)
{
    const foreign_plant_config_t *p       = &c->plant;
    const double                  sum     = 1.0 / p->actuator_pole + 1.0 / p->sensor_pole + p->damping + 1.5 * c->h_s;
    const double                  largest = fmax(p->damping, fmax(1.0 / p->actuator_pole, 1.0 / p->sensor_pole));
    const double                  rest    = sum - largest;
    c->kp                                 = largest / (2.0 * rest) / spread(seed, 1.0, 4.0);
    c->ki_per_s                           = c->kp / fmin(largest, 8.0 * rest);
}

static case_t drawn(uint64_t number)
{
    uint64_t seed = number * 0x9e3779b97f4a7c15u + 77u;
    for (int i = 0; i < 5; i++)
    {
        (void)foreign_random(&seed);
    }
    case_t                  c = {.force = spread(&seed, 0.1, 500.0), .h_s = 1.0 / spread(&seed, 500.0, 10000.0)};
    foreign_plant_config_t *p = &c.plant;
    c.wave                    = (wave_t)pick(&seed, WAVES);
    p->law                    = (foreign_law_t)pick(&seed, FOREIGN_LAWS);
    p->actuator_pole          = spread(&seed, 100.0, 2000.0);
    p->sensor_pole            = spread(&seed, 40.0, 600.0);
    const double damping      = spread(&seed, 0.0005, 0.008);
    const double resonance    = spread(&seed, 150.0, 800.0);
    const double slope        = uniform(&seed, 0.05, 0.3);
    const double offset       = uniform(&seed, 0.0, 0.08) * c.force;
    const double asymmetry    = uniform(&seed, -0.15, 0.15);
    c.period_s                = spread(&seed, 0.8, 20.0);
    p->inertia                = 1.0 / (resonance * resonance);
    p->damping                = damping + 0.6 / resonance;
    p->offset[0]              = offset * (1.0 + asymmetry);
    p->offset[1]              = offset * (1.0 - asymmetry);
    p->slope[0]               = slope * (1.0 + asymmetry);
    p->slope[1]               = slope * (1.0 - asymmetry);
    p->sliding                = uniform(&seed, 0.85, 1.0);
    p->stribeck               = spread(&seed, 0.02, 1.0) * c.force;
    p->presliding             = spread(&seed, 0.003, 0.03) * c.force;
    p->creep                  = spread(&seed, 0.002, 0.05) * c.force;
    p->noise                  = foreign_random(&seed) < -0.4 ? 0.0 : spread(&seed, 1e-5, 2e-3) * c.force;
    const double bounds[4][2] = {{0.7, 1.4}, {0.7, 1.3}, {0.8, 1.25}, {0.8, 1.25}};
    for (int i = 0; i < 4; i++)
    {
        c.belief[i] = uniform(&seed, bounds[i][0], bounds[i][1]);
    }
    tune(&c, &seed);
    return c;
}

static double triangle(double phase)
{
    return phase < 0.5 ? 4.0 * phase - 1.0 : 3.0 - 4.0 * phase;
}

/// The reference, 0.6 to 1 times the usual force after half a second.
static double reference(const case_t *c, double t)
{
    const double phase  = fmod(t, c->period_s) / c->period_s;
    const double wave[] = {triangle(phase),
                           sin(TWO_PI * phase),
                           0.7 * triangle(phase) + 0.3 * triangle(fmod(7.3 * t, c->period_s) / c->period_s),
                           phase < 0.5 ? -1.0 : 1.0,
                           fmax(-1.0, fmin(1.0, 1.25 * triangle(phase)))};
    return c->force * (0.8 + 0.2 * wave[c->wave]) * fmin(1.0, 2.0 * t);
}

/// The u of the PI alone: what the user had before.
static double pi_step(const case_t *c, double *integral, double e)
{
    const double next = *integral + c->ki_per_s * c->h_s * e;
    const double u    = c->kp * e + next;
    const double most = 2.5 * c->force;
    *integral         = fabs(u) <= most ? next : *integral;
    return fmax(-most, fmin(most, u));
}

static tribo_status_t init(AXIS(t) * axis, const case_t *c)
{
    const foreign_plant_config_t *p      = &c->plant;
    tribo_axis_f32_config_t       config = tribo_axis_f32_config();

    config.sample_time_s                       = (float)c->h_s;
    config.u_min_n                             = (float)(-2.5 * c->force);
    config.u_max_n                             = (float)(2.5 * c->force);
    config.usual_force_n                       = (float)c->force;
    config.positive.offset_n                   = (float)(c->belief[0] * 0.5 * (p->offset[0] + p->offset[1]));
    config.positive.slope                      = (float)(c->belief[0] * 0.5 * (p->slope[0] + p->slope[1]));
    config.arm_lag_s                           = (float)(c->belief[1] * p->damping);
    config.noise_n                             = (float)p->noise;
    config.controller                          = tribo_pi((float)c->kp, (float)c->ki_per_s);
    config.feedforward.actuator_pole_rad_per_s = (float)(c->belief[2] * p->actuator_pole);
    config.feedforward.sensor_pole_rad_per_s   = (float)(c->belief[3] * p->sensor_pole);
#ifdef TRIBO_ARITHMETIC_Q31
    return tribo_axis_q31_init(axis, &config, (float)(8.0 * c->force));
#else
    return tribo_axis_f32_init(axis, &config);
#endif
}

static double step(AXIS(t) * axis, const case_t *c, double r, double y)
{
#ifdef TRIBO_ARITHMETIC_Q31
    const double unit = 8.0 * c->force / 2147483648.0;
    const double u    = unit * tribo_axis_q31_step(axis, (int32_t)(r / unit), (int32_t)(y / unit));
    (void)tribo_axis_q31_learn(axis);
    return u;
#else
    (void)c;
    return (double)tribo_axis_f32_step(axis, (float)r, (float)y);
#endif
}

/// RMS of r - F, with `axis`, or with the PI alone if it is null.
static double run(const case_t *c, AXIS(t) * axis)
{
    foreign_plant_config_t config   = c->plant;
    const int              substeps = (int)fmax(4.0, ceil(c->h_s / 1e-4));
    const double           end_s    = fmax(30.0, fmin(70.0, 6.0 * c->period_s));
    config.step_s                   = c->h_s / substeps;
    foreign_plant_t plant;
    foreign_plant_open(&plant, &config, 1);
    double integral = 0.0, square = 0.0;
    long   count = 0;
    for (long k = 0; (double)k * c->h_s < end_s; k++)
    {
        const double t = (double)k * c->h_s;
        const double r = reference(c, t);
        const double y = foreign_plant_read(&plant);
        const double u = axis != NULL ? step(axis, c, r, y) : pi_step(c, &integral, r - y);
        for (int i = 0; i < substeps; i++)
        {
            foreign_plant_step(&plant, u, 0.0, 0.0);
        }
        if (t >= end_s / 3.0)
        {
            const double e = r - foreign_plant_force(&plant);
            square += e * e;
            count++;
        }
    }
    return sqrt(square / (double)count);
}

/// The number of directions, 0 to 2, whose interval holds the breakaway at the usual force.
static int held(const case_t *c, const tribo_axis_report_t *report)
{
    int count = 0;
    for (int i = 0; i < 2; i++)
    {
        const double truth = c->plant.offset[i] + c->plant.slope[i] * c->force;
        count += (double)report->low_n[i] <= truth && truth <= (double)report->high_n[i];
    }
    return count;
}

typedef struct
{
    double   ratio;
    long     seed;
    int      held;
    uint32_t warnings;
} result_t;

static int by_ratio(const void *a, const void *b)
{
    const double x = ((const result_t *)a)->ratio, y = ((const result_t *)b)->ratio;
    return (x > y) - (x < y);
}

static void print_case(const result_t *result)
{
    const case_t c        = drawn((uint64_t)result->seed);
    uint32_t     warnings = result->warnings;
    printf("  %4ld: %.2f, %s, %s, %.2g N, %.2g s, %.0f Hz, noise %.1e of the force\n",
           result->seed,
           result->ratio,
           wave_names[c.wave],
           law_names[c.plant.law],
           c.force,
           c.period_s,
           1.0 / c.h_s,
           c.plant.noise / c.force);
    for (const char *text = tribo_axis_warning(&warnings); text != NULL; text = tribo_axis_warning(&warnings))
    {
        printf("        %s\n", text);
    }
}

int main(int argc, char **argv)
{
    static AXIS(t) axis;
    static result_t results[SEEDS_MAX];
    const long      first = argc > 2 ? strtol(argv[1], NULL, 10) : 1;
    const long      last  = argc > 2 ? strtol(argv[2], NULL, 10) : 1;
    long            count = 0, hits = 0, below = 0;
    for (long seed = first; seed <= last && count < SEEDS_MAX; seed++)
    {
        const case_t         c      = drawn((uint64_t)seed);
        const tribo_status_t status = init(&axis, &c);
        if (status != TRIBO_OK)
        {
            printf("%ld: %s\n", seed, tribo_status_text(status));
            return 1;
        }
        const double        without = run(&c, NULL);
        const double        with    = run(&c, &axis);
        tribo_axis_report_t report;
        AXIS(report)(&axis, &report);
        results[count] = (result_t){without / with, seed, held(&c, &report), report.warnings};
        hits += results[count].held;
        below += !(results[count].ratio >= 0.9);
        count++;
    }
    qsort(results, (size_t)count, sizeof results[0], by_ratio);
    for (long i = 0; i < count && i < SHOWN; i++)
    {
        print_case(&results[i]);
    }
    const double median = results[count / 2].ratio;
    const double part   = 50.0 * (double)hits / (double)count;
    printf(
        "%ld axes: without/with least %.2f, median %.2f, %ld below 0.9; %.0f %% of the intervals hold the breakaway\n",
        count,
        results[0].ratio,
        median,
        below,
        part);
    return below > 0 || median < 5.0 || part < 80.0;
}
