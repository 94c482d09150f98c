// Judges the library's feed-forward on all truths, the guard beside it. Not a test; run it by hand:
//
//     build/host-release/tests/closed_loop/feedforward_study_f32 drift MINUTES | iterative | rivals       or feedforward_study_q31
//
// A ratio is the RMS of r - F without over that with the feed-forward, after the first third of a run, with the same plant and
// noise.

#include ARITH_HEADER

#include "plant/plant.h"
#include "plant/random.h"
#include "rivals.h"
#include "scenario/config.h"
#include "tribo/feedforward_f32.h"
#include "tribo/paper_controller.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define H            1e-3
#define STEPS_A_TICK 10
#define PI           3.141592653589793

typedef struct
{
    int    truth;
    double breakaway;     // of the truth over the model's
    double actuator_gain; // of the truth
    double noise_n;       // standard deviation
    double bad;           // share of readings that are none
    int    seed;          // of the noise
    double (*reference)(const double of[3], double t);
    double of[3]; // low, high, and a slope in N/s or a time in s
    double third_s;
} case_t;

typedef enum
{
    OFF,
    PAPER,
    FEEDFORWARD,
    RIVAL
} method_t;

typedef struct
{
    method_t                       method;
    tribo_feedforward_f32_config_t feedforward;
    double                         gain; // times the paper's controller
    rival_law_t                    rival;
} options_t;

#define OF_INSIDE(x) TRIBO_EITHER(x, (x) * FULL_SCALE_N / 536870912.0) // a force of the state

static const options_t off = {.method = OFF, .gain = 1.0};

static double triangle(const double of[3], double t)
{
    const double swing = of[1] - of[0];
    const double gone  = fmod(t * of[2], 2.0 * swing);
    return of[0] + (gone < swing ? gone : 2.0 * swing - gone);
}

static double sine(const double of[3], double t)
{
    return 0.5 * (of[0] + of[1]) + 0.5 * (of[1] - of[0]) * sin(2.0 * PI * t / of[2]);
}

// --- one run --------------------------------------------------------------------------------------------------------

typedef struct
{
    common_scenario_t *scenario; // for the plant's defaults
    sim_plant_config_t config;
    double             own[SIM_TRUTH_DOUBLES_MAX];
    sim_plant_t       *plant;
    sim_random_t       random;
    loop_t             loop;
    guard_t            guard;
    rival_t            rival;
    bool               is_rival;
} rig_t;

static void fail(const char *what)
{
    (void)fprintf(stderr, "feedforward_study: %s\n", what);
    exit(1);
}

static void open_loop(rig_t *rig, const options_t *options)
{
    tribo_force_loop_f32_config_t config = tribo_force_loop_f32_paper();
    tribo_status_t                status = TRIBO_OK;
    tribo_biquad_f32_section_t    section[TRIBO_PAPER_CONTROLLER_SECTION_COUNT];
    memcpy(section, tribo_paper_controller_f32, sizeof section);
    section[0].b0 *= (float)options->gain;
    section[0].b1 *= (float)options->gain;
    section[0].b2 *= (float)options->gain;
    config.controller.sections = section;
    if (options->method != PAPER)
    {
        config.gain = 0.0f;
    }
    if (options->method == FEEDFORWARD)
    {
        status = loop_init_feedforward(&rig->loop, &config, &options->feedforward);
    }
    else
    {
        status = loop_init(&rig->loop, &config);
    }
    if (status != TRIBO_OK || guard_init(&rig->guard, H) != TRIBO_OK)
    {
        fail(tribo_status_text(status));
    }
}

static void open_rig(rig_t *rig, const case_t *x, const options_t *options)
{
    rig->is_rival = options->method == RIVAL;
    open_loop(rig, options);
    rig->scenario = sim_scenario_create();
    if (rig->scenario == NULL)
    {
        fail("no memory");
    }
    const sim_config_t *defaults = sim_scenario_config(rig->scenario);
    memcpy(rig->own, defaults->plant.own[x->truth], sizeof rig->own);
    rig->config = (sim_plant_config_t){
        .step_s                  = H / STEPS_A_TICK,
        .actuator_pole_rad_per_s = defaults->plant.actuator_pole_rad_per_s,
        .sensor_pole_rad_per_s   = defaults->sensor.pole_rad_per_s,
        .truth                   = {.friction = defaults->plant.friction, .arm = defaults->plant.arm, .own = rig->own}};
    const rival_config_t believed = {.offset_n = rig->config.truth.friction.breakaway.offset_n,
                                     .slope    = rig->config.truth.friction.breakaway.slope,
                                     .gain     = options->gain,
                                     .sigma_n  = x->noise_n};
    rival_open(&rig->rival, options->rival, &believed);
    rig->config.truth.friction.breakaway.offset_n *= x->breakaway;
    rig->config.truth.friction.breakaway.slope *= x->breakaway;
    rig->plant = sim_plant_create(&rig->config, sim_truth_models[x->truth]);
    if (rig->plant == NULL)
    {
        fail("no plant");
    }
    sim_random_seed(&rig->random, (uint64_t)x->seed);
}

static void close_rig(rig_t *rig)
{
    sim_plant_destroy(rig->plant);
    common_scenario_destroy(rig->scenario);
}

static double uniform(sim_random_t *random, double low, double high)
{
    return low + (high - low) * (double)(sim_random_bits(random) >> 11) / 9007199254740992.0;
}

static double reading(rig_t *rig, const case_t *x)
{
    const double y = sim_plant_filtered_force(rig->plant) + x->noise_n * sim_random_normal(&rig->random);
    return x->bad > 0.0 && uniform(&rig->random, 0.0, 1.0) < x->bad ? 1e9 : y;
}

/// One tick to reference `r`.
static void tick_rig(rig_t *rig, const case_t *x, double r)
{
    sim_plant_signals_t unseen;
    const double        y = reading(rig, x);
    const double u = rig->is_rival ? rival_step(&rig->rival, r, y) : loop_step_guarded(&rig->loop, &rig->guard, r, y);
    for (int i = 0; i < STEPS_A_TICK; i++)
    {
        sim_plant_step(rig->plant, x->actuator_gain * u, &unseen);
    }
}

/// RMS of r - F over the last two thirds, in N.
static double run(const case_t *x, const options_t *options)
{
    rig_t      rig;
    double     sum   = 0.0;
    const long third = lround(x->third_s / H);
    open_rig(&rig, x, options);
    for (long k = 0; k < 3 * third; k++)
    {
        const double r     = x->reference(x->of, (double)k * H);
        const double error = k < third ? 0.0 : r - sim_plant_force(rig.plant);
        sum += error * error;
        tick_rig(&rig, x, r);
    }
    close_rig(&rig);
    return sqrt(sum / (double)(2 * third));
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

static case_t benchmark(int truth)
{
    return (case_t){.truth         = truth,
                    .breakaway     = 1.0,
                    .actuator_gain = 1.0,
                    .seed          = 1,
                    .reference     = triangle,
                    .of            = {0.4, 0.6, 0.02},
                    .third_s       = 20.0};
}

// --- the studies ----------------------------------------------------------------------------------------------------

/// A random rig over all truths; `i` of a row of them.
static case_t random_case(sim_random_t *random, size_t i)
{
    case_t x        = benchmark((int)uniform(random, 0.0, SIM_TRUTH_COUNT));
    x.breakaway     = uniform(random, 0.6, 1.4);
    x.actuator_gain = uniform(random, 0.95, 1.05);
    x.noise_n       = fmax(0.0, uniform(random, -1e-3, 1e-3));
    x.seed          = (int)i;
    x.reference     = i % 3 == 0 ? sine : triangle;
    x.of[0]         = uniform(random, 0.1, 0.4);
    x.of[1]         = x.of[0] + uniform(random, 0.1, 0.4);
    x.of[2]         = i % 3 == 0 ? uniform(random, 2.0, 20.0) : uniform(random, 0.01, 0.08);
    x.third_s       = i % 3 == 0 ? 2.0 * x.of[2] : 2.0 * (x.of[1] - x.of[0]) / x.of[2];
    return x;
}

/// The largest |b| in the first minute and in the rest, at rates, breakaways and with 2 % bad readings.
static void study_drift(const options_t *options, long minutes)
{
    static const double rates[]     = {0.02, 0.2, 0.4, 0.8, 1.2};
    static const double breakaway[] = {0.6, 1.0, 1.5};
    for (int bad = 0; bad < 2; bad++)
    {
        for (size_t i = 0; i < sizeof rates / sizeof rates[0]; i++)
        {
            for (size_t j = 0; j < 3u; j++)
            {
                case_t x    = benchmark(SIM_TRUTH_paper);
                x.breakaway = breakaway[j];
                x.of[2]     = rates[i];
                x.bad       = bad == 1 ? 0.02 : 0.0;
                rig_t rig;
                open_rig(&rig, &x, options);
                double first = 0.0;
                double rest  = 0.0;
                double rms   = 0.0;
                double last  = 0.0;
                for (long k = 0; k < minutes * 60000; k++)
                {
                    const double r     = triangle(x.of, (double)k * H);
                    const double error = r - sim_plant_force(rig.plant);
                    tick_rig(&rig, &x, r);
                    const double b = fabs(OF_INSIDE((double)rig.loop.memory.state.b));
                    first          = k < 60000 ? fmax(first, b) : first;
                    rest           = fmax(rest, b);
                    rms += k < 60000 && k >= 20000 ? error * error / 40000.0 : 0.0;
                    last += k >= (minutes - 1) * 60000 ? error * error / 60000.0 : 0.0;
                }
                close_rig(&rig);
                printf("  %-4s %.2f N/s, L x%.1f: |b| up to %.4f in a minute, %.4f in all; %.3f and %.3f mN\n",
                       bad == 1 ? "bad" : "",
                       rates[i],
                       breakaway[j],
                       first,
                       rest,
                       1e3 * sqrt(rms),
                       1e3 * sqrt(last));
                (void)fflush(stdout);
            }
        }
    }
}

/// The rival for periodic references: learns an addition to r, tick by tick, from the error of the last period.
static void study_iterative(void)
{
    static const double gain   = 0.3;
    static const int    ahead  = 60; // ticks from u to F
    const long          period = 20000;
    static double       learned[20000];
    static double       errors[20000];
    static const int    truths[] = {SIM_TRUTH_paper, SIM_TRUTH_coulomb, SIM_TRUTH_leuven, SIM_TRUTH_maxwell_slip};
    for (size_t i = 0; i < sizeof truths / sizeof truths[0]; i++)
    {
        const case_t x = benchmark(truths[i]);
        rig_t        rig;
        open_rig(&rig, &x, &off);
        memset(learned, 0, sizeof learned);
        printf("  iterative, %-14s mN in periods 1, 2, 5, 10, 20:", sim_truth_models[x.truth]->name);
        for (int turn = 1; turn <= 20; turn++)
        {
            double sum = 0.0;
            for (long k = 0; k < period; k++)
            {
                const double r = triangle(x.of, (double)k * H);
                errors[k]      = r - sim_plant_force(rig.plant);
                sum += errors[k] * errors[k];
                tick_rig(&rig, &x, r + learned[k]);
            }
            for (long k = 0; k < period; k++)
            {
                double mean = 0.0;
                for (long j = -5; j <= 5; j++)
                {
                    mean += errors[(k + ahead + j + period) % period] / 11.0;
                }
                learned[k] += gain * mean;
            }
            if (turn == 1 || turn == 2 || turn == 5 || turn == 10 || turn == 20)
            {
                printf(" %.3f", 1e3 * sqrt(sum / (double)period));
            }
        }
        printf("\n");
        close_rig(&rig);
    }
}

// --- rivals ---------------------------------------------------------------------------------------------------------

/// RMS of r - F in mN with 1 mN of noise over three seeds, of the benchmark.
static double noisy_mn(const options_t *options)
{
    double sum = 0.0;
    for (int seed = 1; seed <= 3; seed++)
    {
        case_t x  = benchmark(SIM_TRUTH_paper);
        x.noise_n = 1e-3;
        x.seed    = seed;
        sum += 1e3 / 3.0 * run(&x, options);
    }
    return sum;
}

/// One row of the table: without compensation is the paper's controller at gain 1, for all.
static void study_rival(const char *name, const options_t *options)
{
    enum
    {
        RANDOM = 60
    };
    static double quiet[SIM_TRUTH_COUNT];
    static double random_off[RANDOM];
    const bool    first = quiet[0] == 0.0;
    double        ratios[SIM_TRUTH_COUNT];
    double        rig[RANDOM];
    double        triangle_mn = 0.0;
    sim_random_t  random;
    for (int truth = 0; truth < SIM_TRUTH_COUNT; truth++)
    {
        const case_t x = benchmark(truth);
        quiet[truth]   = first ? run(&x, &off) : quiet[truth];
        const double e = run(&x, options);
        ratios[truth]  = quiet[truth] / e;
        triangle_mn    = truth == SIM_TRUTH_paper ? 1e3 * e : triangle_mn;
    }
    sim_random_seed(&random, 5u);
    for (size_t i = 0; i < RANDOM; i++)
    {
        const case_t x = random_case(&random, i);
        random_off[i]  = first ? run(&x, &off) : random_off[i];
        rig[i]         = random_off[i] / run(&x, options);
    }
    qsort(ratios, SIM_TRUTH_COUNT, sizeof ratios[0], ascending);
    qsort(rig, RANDOM, sizeof rig[0], ascending);
    printf("| %-26s | %7.3f | %7.2f | %5.2f | %5.1f | %5.2f | %5.1f |\n",
           name,
           triangle_mn,
           noisy_mn(options),
           ratios[0],
           0.5 * (ratios[(SIM_TRUTH_COUNT - 1) / 2] + ratios[SIM_TRUTH_COUNT / 2]),
           rig[0],
           0.5 * (rig[RANDOM / 2 - 1] + rig[RANDOM / 2]));
    (void)fflush(stdout);
}

/// All beside each other, ratios over the paper's controller without compensation. In Markdown.
static void study_rivals(const options_t *options)
{
    options_t x = *options;
    char      name[64];
    printf("| method | triangle, mN | with 1 mN of noise, mN | truths: least | median | random rigs: least | median |\n"
           "|---|---|---|---|---|---|---|\n");
    for (int gain = 1; gain <= 4; gain += gain == 1 ? 2 : 1)
    {
        static const method_t method[] = {PAPER, FEEDFORWARD};
        x.gain                         = gain;
        for (int i = 0; i < 2; i++)
        {
            x.method = method[i];
            (void)snprintf(name, sizeof name, "%s, K x %d", i == 0 ? "paper" : "feed-forward", gain);
            study_rival(name, &x);
        }
        x.method = RIVAL;
        for (int rival = 0; rival < RIVALS; rival++)
        {
            x.rival = (rival_law_t)rival;
            (void)snprintf(name, sizeof name, "%s, K x %d", rival_names[rival], gain);
            if (rival != RIVAL_LADRC || gain == 1)
            {
                study_rival(name, &x);
            }
        }
    }
}

int main(int argc, char **argv)
{
    const char *const what    = argc > 1 ? argv[1] : "";
    const long        minutes = argc > 2 ? strtol(argv[2], NULL, 10) : 0;
    const options_t   options = {.method = FEEDFORWARD, .feedforward = tribo_feedforward_f32_default(), .gain = 1.0};
    if (strcmp(what, "drift") == 0 && minutes > 0)
    {
        study_drift(&options, minutes);
    }
    else if (strcmp(what, "iterative") == 0)
    {
        study_iterative();
    }
    else if (strcmp(what, "rivals") == 0)
    {
        study_rivals(&options);
    }
    else
    {
        (void)fputs("usage: feedforward_study_f32|q31 drift MINUTES | iterative | rivals\n", stderr);
        return 2;
    }
    return 0;
}
