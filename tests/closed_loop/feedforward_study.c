// Judges the library's feed-forward on all truths, the guard beside it. Not a test; run it by hand:
//
//     build/host-release/tests/closed_loop/feedforward_study_f32 [NAME=VALUE...] STUDY...                 or feedforward_study_q31
//
// A ratio is the RMS of r - F without over that with the feed-forward, after the first third of a run, with the same plant and
// noise. NAME is a key of compensator.feedforward, or factor: on f, to see what the monitor makes of too much. STUDY is one of:
// truths, ratios, triangles, waves, steps, across, random, pushes, environment, rest, hold, loads, long, harm, iterative, rivals.

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
#define MOST_CASES   1024

typedef struct
{
    int    truth;
    double breakaway;     // of the truth over the model's
    double sliding;       // level of sliding over breakaway, for truths that have one
    double actuator_gain; // of the truth
    double noise_n;       // standard deviation
    double bad;           // share of readings that are none
    int    seed;          // of the noise
    double (*reference)(const double of[3], double t);
    double of[3]; // low, high, and a slope in N/s or a time in s
    double third_s;
    double push_n, push_s, push_time_s;   // a force on the arm, from when and for how long
    double environment_n, environment_hz; // amplitude of its movement times the stiffness, and frequency
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
    double                         factor; // on f: 1 or 2
    double                         gain;   // times the paper's controller
    rival_law_t                    rival;
} options_t;

#define OF_INSIDE(x) TRIBO_EITHER(x, (x) * FULL_SCALE_N / 536870912.0) // a force of the state

static double drift_minutes = 10.0;

static const options_t off   = {.method = OFF, .gain = 1.0};
static const options_t paper = {.method = PAPER, .gain = 1.0};

static double triangle(const double of[3], double t)
{
    const double swing = of[1] - of[0];
    const double gone  = fmod(t * of[2], 2.0 * swing);
    return of[0] + (gone < swing ? gone : 2.0 * swing - gone);
}

static double stairs(const double of[3], double t)
{
    const int step = (int)(t / of[2]) % 10;
    return of[0] + (step < 5 ? step : 10 - step) * (of[1] - of[0]) / 5.0;
}

static double sawtooth(const double of[3], double t)
{
    return of[0] + (of[1] - of[0]) * fmod(t, of[2]) / of[2];
}

static double sine(const double of[3], double t)
{
    return 0.5 * (of[0] + of[1]) + 0.5 * (of[1] - of[0]) * sin(2.0 * PI * t / of[2]);
}

/// Straight lines between random points.
static double walk(const double of[3], double t)
{
    double       at[2];
    const double place = t / of[2];
    for (int i = 0; i < 2; i++)
    {
        sim_random_t random;
        sim_random_seed(&random, (uint64_t)place + (uint64_t)i);
        at[i] = (double)(sim_random_bits(&random) >> 11) / 9007199254740992.0;
    }
    return of[0] + (of[1] - of[0]) * (at[0] + (place - floor(place)) * (at[1] - at[0]));
}

static double square(const double of[3], double t)
{
    return fmod(t, of[2]) < 0.5 * of[2] ? of[0] : of[1];
}

/// A period of the triangle, then up to its middle, and to rest.
static double rest(const double of[3], double t)
{
    const double period = 2.0 * (of[1] - of[0]) / of[2];
    return triangle(of, fmin(t, 1.25 * period));
}

// --- one run --------------------------------------------------------------------------------------------------------

typedef struct
{
    common_scenario_t *scenario; // for the plant's defaults
    sim_plant_config_t config;
    double             own[SIM_TRUTH_DOUBLES_MAX];
    sim_plant_t       *plant;
    sim_random_t       random;
    double             t;
    double             environment_n, environment_rad_per_s;
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
    if (options->method == FEEDFORWARD && options->factor != 1.0)
    {
#if TRIBO_IS_Q31
        fail("factor: in float32 alone");
#else
        rig->loop.feedforward.trust          = (float)options->factor;
        rig->loop.feedforward.learning.trust = (float)options->factor;
#endif
    }
}

/// Sets the truth's sliding friction, for truths with a separate breakaway.
static void set_sliding(rig_t *rig, const case_t *x)
{
    const sim_truth_ops_t *truth = sim_truth_models[x->truth];
    for (const common_key_t *key = truth->keys; key != NULL && key->name != NULL; key++)
    {
        if (x->sliding < 1.0 && strcmp(key->name, "sliding_ratio") == 0)
        {
            memcpy((char *)rig->own + key->offset, &x->sliding, sizeof x->sliding);
        }
    }
}

static void open_rig(rig_t *rig, const case_t *x, const options_t *options)
{
    rig->t                     = 0.0;
    rig->environment_n         = x->environment_n;
    rig->environment_rad_per_s = 2.0 * PI * x->environment_hz;
    rig->is_rival              = options->method == RIVAL;
    open_loop(rig, options);
    rig->scenario = sim_scenario_create();
    if (rig->scenario == NULL)
    {
        fail("no memory");
    }
    const sim_config_t *defaults = sim_scenario_config(rig->scenario);
    memcpy(rig->own, defaults->plant.own[x->truth], sizeof rig->own);
    set_sliding(rig, x);
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

/// An environment that has moved by x takes K x from the force, and is K x more for the arm; before the pole p of the actuator
/// (1 + s/p) K x.
static double environment_in_front(const rig_t *rig, double t)
{
    const double phase = rig->environment_rad_per_s * t;
    const double lead  = rig->environment_rad_per_s / rig->config.actuator_pole_rad_per_s;
    return rig->environment_n * (sin(phase) + lead * cos(phase));
}

static double force(const rig_t *rig)
{
    return sim_plant_force(rig->plant) - rig->environment_n * sin(rig->environment_rad_per_s * rig->t);
}

static double uniform(sim_random_t *random, double low, double high)
{
    return low + (high - low) * (double)(sim_random_bits(random) >> 11) / 9007199254740992.0;
}

/// The reading, with the environment's movement through the sensor's pole.
static double reading(rig_t *rig, const case_t *x)
{
    const double phase = rig->environment_rad_per_s * rig->t;
    const double lag   = rig->environment_rad_per_s / rig->config.sensor_pole_rad_per_s;
    const double swing = rig->environment_n * (sin(phase) - lag * cos(phase)) / (1.0 + lag * lag);
    const double y     = sim_plant_filtered_force(rig->plant) - swing + x->noise_n * sim_random_normal(&rig->random);
    return x->bad > 0.0 && uniform(&rig->random, 0.0, 1.0) < x->bad ? 1e9 : y;
}

/// One tick to reference `r`.
static void tick_rig(rig_t *rig, const case_t *x, double r)
{
    sim_plant_signals_t unseen;
    const double        since = rig->t - x->push_s;
    const double        push  = since >= 0.0 && since < x->push_time_s ? x->push_n : 0.0;
    const double        y     = reading(rig, x);
    const double u = rig->is_rival ? rival_step(&rig->rival, r, y) : loop_step_guarded(&rig->loop, &rig->guard, r, y);
    for (int i = 0; i < STEPS_A_TICK; i++)
    {
        const double moved = environment_in_front(rig, rig->t + i * rig->config.step_s);
        sim_plant_step(rig->plant, x->actuator_gain * u + push + moved, &unseen);
    }
    rig->t += H;
}

/// RMS of r - F in `count` windows of one period each that end at `ends`, ascending, in s.
static void run_windows(const case_t    *x,
                        const options_t *options,
                        double           period_s,
                        const double    *ends,
                        double          *rms,
                        int              count)
{
    rig_t rig;
    open_rig(&rig, x, options);
    for (int i = 0; i < count; i++)
    {
        rms[i] = 0.0;
    }
    for (long k = 0; k < lround(ends[count - 1] / H); k++)
    {
        const double t     = (double)k * H;
        const double r     = x->reference(x->of, t);
        const double error = r - force(&rig);
        for (int i = 0; i < count; i++)
        {
            rms[i] += t >= ends[i] - period_s && t < ends[i] ? error * error * H / period_s : 0.0;
        }
        tick_rig(&rig, x, r);
    }
    for (int i = 0; i < count; i++)
    {
        rms[i] = sqrt(rms[i]);
    }
    close_rig(&rig);
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
        const double error = k < third ? 0.0 : r - force(&rig);
        sum += error * error;
        tick_rig(&rig, x, r);
    }
    close_rig(&rig);
    return sqrt(sum / (double)(2 * third));
}

static double ratio(const case_t *x, const options_t *options)
{
    return run(x, &off) / run(x, options);
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

static void print(const char *name, double *ratios, size_t count)
{
    size_t worse = 0;
    for (size_t i = 0; i < count; i++)
    {
        worse += ratios[i] < 1.0;
    }
    qsort(ratios, count, sizeof ratios[0], ascending);
    printf("%-36s %4zu cases: least %.2f, 5 %% %.2f, median %.2f, below 1 in %zu\n",
           name,
           count,
           ratios[0],
           ratios[count / 20],
           0.5 * (ratios[(count - 1) / 2] + ratios[count / 2]),
           worse);
    (void)fflush(stdout);
}

static case_t benchmark(int truth)
{
    return (case_t){.truth         = truth,
                    .breakaway     = 1.0,
                    .sliding       = 1.0,
                    .actuator_gain = 1.0,
                    .seed          = 1,
                    .reference     = triangle,
                    .of            = {0.4, 0.6, 0.02},
                    .third_s       = 20.0};
}

// --- the studies ----------------------------------------------------------------------------------------------------

static void study_truths(const options_t *options)
{
    double ratios[SIM_TRUTH_COUNT];
    for (int truth = 0; truth < SIM_TRUTH_COUNT; truth++)
    {
        const case_t x   = benchmark(truth);
        const double rms = run(&x, options);
        ratios[truth]    = run(&x, &off) / rms;
        printf("  %-18s %.3f mN, %.2f times\n", sim_truth_models[truth]->name, 1e3 * rms, ratios[truth]);
    }
    print("truths, triangle", ratios, SIM_TRUTH_COUNT);
}

static void study_ratios(const options_t *options)
{
    static const int    truth[]   = {SIM_TRUTH_karnopp, SIM_TRUTH_leuven, SIM_TRUTH_maxwell_slip};
    static const double sliding[] = {0.85, 0.7, 0.6};
    double              ratios[9];
    double              later[9];
    int                 worse = 0; // than the paper's method by more than 5 %
    for (int i = 0; i < 9; i++)
    {
        case_t x           = benchmark(truth[i / 3]);
        x.sliding          = sliding[i % 3];
        ratios[i]          = ratio(&x, options);
        const double other = ratio(&x, &paper);
        worse += ratios[i] < 0.95 * other;
        x.third_s = 80.0;
        later[i]  = ratio(&x, options);
        printf("  %-18s sliding at %.2f: %.2f times, of four minutes %.2f; the paper's method %.2f\n",
               sim_truth_models[x.truth]->name,
               x.sliding,
               ratios[i],
               later[i],
               other);
    }
    print("the same, four minutes", later, 9);
    print("sliding below breakaway, triangle", ratios, 9);
    printf("  below the paper's method by more than 5 %%: %d\n", worse);
}

static void study_triangles(const options_t *options)
{
    static const double range[8][2] =
        {{0.1, 0.3}, {0.2, 0.5}, {0.2, 0.6}, {0.3, 0.5}, {0.4, 0.6}, {0.1, 0.5}, {-0.2, 0.2}, {-0.4, 0.4}};
    static const double slope[4]     = {0.01, 0.015, 0.02, 0.04};
    static const double breakaway[5] = {1.0, 0.8, 1.2, 0.5, 1.5};
    for (int set = 0; set < 30; set++) // quiet, then with five noise seeds
    {
        double ratios[32];
        char   name[64];
        for (int i = 0; i < 32; i++)
        {
            case_t x    = benchmark(SIM_TRUTH_paper);
            x.breakaway = breakaway[set % 5];
            x.seed      = set / 5;
            x.noise_n   = set < 5 ? 0.0 : 1e-3;
            x.of[0]     = range[i / 4][0];
            x.of[1]     = range[i / 4][1];
            x.of[2]     = slope[i % 4];
            x.third_s   = 2.0 * (x.of[1] - x.of[0]) / x.of[2];
            ratios[i]   = ratio(&x, options);
        }
        (void)snprintf(name, sizeof name, "triangles, L x%.1f, noise %d mN, %d", breakaway[set % 5], set >= 5, set / 5);
        print(name, ratios, 32);
    }
}

static void study_waves(const options_t *options)
{
    static const struct
    {
        const char *name;
        double (*reference)(const double of[3], double t);
        double of[3], third_s;
    } wave[] = {{"steps", square, {0.4, 0.6, 10.0}, 10.0},
                {"small steps", square, {0.4, 0.42, 10.0}, 10.0},
                {"stairs", stairs, {0.4, 0.6, 2.0}, 20.0},
                {"quick stairs", stairs, {0.2, 0.6, 1.0}, 10.0},
                {"sawtooth", sawtooth, {0.4, 0.6, 10.0}, 10.0},
                {"quick sawtooth", sawtooth, {0.3, 0.6, 4.0}, 8.0},
                {"slow sine", sine, {0.4, 0.6, 20.0}, 20.0},
                {"sine", sine, {0.4, 0.6, 5.0}, 10.0},
                {"quick sine", sine, {0.4, 0.6, 1.0}, 4.0},
                {"walk", walk, {0.4, 0.6, 1.5}, 20.0},
                {"wide walk", walk, {0.2, 0.6, 1.5}, 20.0}};
    for (size_t i = 0; i < sizeof wave / sizeof wave[0]; i++)
    {
        double ratios[SIM_TRUTH_COUNT];
        for (int truth = 0; truth < SIM_TRUTH_COUNT; truth++)
        {
            case_t x    = benchmark(truth);
            x.reference = wave[i].reference;
            x.third_s   = wave[i].third_s;
            memcpy(x.of, wave[i].of, sizeof x.of);
            ratios[truth] = ratio(&x, options);
        }
        print(wave[i].name, ratios, SIM_TRUTH_COUNT);
    }
}

/// Triangles across 0 with a wrong scale of u.
static void study_across(const options_t *options)
{
    static const double gain[] = {1.0, 0.95, 1.05, 0.86};
    for (int i = 0; i < 4; i++)
    {
        case_t x        = benchmark(SIM_TRUTH_paper);
        x.actuator_gain = gain[i];
        x.of[0]         = -0.25;
        x.of[1]         = 0.25;
        x.third_s       = 50.0;
        printf("  across 0, scale of u %.2f: %.2f times\n", gain[i], ratio(&x, options));
    }
}

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

/// Random rigs and references over all truths, in two halves with different seeds.
static void study_random(const options_t *options)
{
    for (uint64_t half = 0; half < 2u; half++)
    {
        static double ratios[MOST_CASES];
        const size_t  count = 500;
        sim_random_t  random;
        sim_random_seed(&random, half + 1u);
        for (size_t i = 0; i < count; i++)
        {
            const case_t x = random_case(&random, i);
            ratios[i]      = ratio(&x, options);
        }
        print(half == 0u ? "random rigs, tuned on" : "random rigs, held out", ratios, count);
    }
}

/// Pushes of 1 s while r moves: the error 60 s later over that before.
static void study_pushes(const options_t *options)
{
    static const int    truths[] = {SIM_TRUTH_paper, SIM_TRUTH_coulomb, SIM_TRUTH_leuven};
    static const double push[]   = {-0.5, -0.3, -0.1, 0.1, 0.3, 0.5};
    for (size_t truth = 0; truth < 3; truth++)
    {
        for (int noisy = 0; noisy < 2; noisy++)
        {
            double worst[6] = {0.0};
            double ratios[48];
            for (int i = 0; i < 48; i++)
            {
                case_t x      = benchmark(truths[truth]);
                x.noise_n     = noisy ? 0.3e-3 : 0.0;
                x.push_n      = push[i / 8];
                x.push_s      = 40.0 + 2.5 * (i % 8);
                x.push_time_s = 1.0;
                double       rms[3];
                double       without[3];
                const double ends[3] = {x.push_s, x.push_s + 20.0, x.push_s + 81.0};
                run_windows(&x, options, 20.0, ends, rms, 3);
                run_windows(&x, &off, 20.0, ends, without, 3);
                ratios[i]    = without[1] / rms[1];
                worst[i / 8] = fmax(worst[i / 8], rms[2] / rms[0]);
                if (rms[2] > 1.5 * rms[0])
                {
                    printf("    push %+.1f N at %.1f s: %.3f mN, then %.2f, then %.3f\n",
                           x.push_n,
                           x.push_s,
                           1e3 * rms[0],
                           1e3 * rms[1],
                           1e3 * rms[2]);
                }
            }
            printf("  %-10s noise %.1f mN, most of error 60 s after a push over before:",
                   sim_truth_models[truths[truth]]->name,
                   0.3 * noisy);
            for (int i = 0; i < 6; i++)
            {
                printf(" %.2f", worst[i]);
            }
            printf("\n");
            print("  its period, without over with", ratios, 48);
        }
    }
}

/// An environment that moves while r does.
static void study_environment(const options_t *options)
{
    static const int    truths[] = {SIM_TRUTH_paper, SIM_TRUTH_coulomb, SIM_TRUTH_leuven};
    static const double hz[]     = {0.1, 0.37, 1.0};
    double              ratios[18];
    for (int i = 0; i < 18; i++)
    {
        case_t x         = benchmark(truths[i / 6]);
        x.environment_n  = i / 3 % 2 == 0 ? 0.02 : 0.05;
        x.environment_hz = hz[i % 3];
        ratios[i]        = ratio(&x, options);
        printf("  %-10s environment of %.2f N at %.2f Hz: %.2f times, the paper's method %.2f\n",
               sim_truth_models[x.truth]->name,
               x.environment_n,
               x.environment_hz,
               ratios[i],
               ratio(&x, &paper));
    }
    print("environment while r moves", ratios, 18);
}

/// Half of the truths: those that constants of the hold were chosen on, or the others.
static const char *const half_name[2] = {"chosen on", "held out"};

/// An environment that moves while r rests.
static void study_rest(const options_t *options)
{
    static const double hz[]        = {0.1, 0.3, 1.0};
    static const double breakaway[] = {1.0, 0.8, 0.5};
    for (int k = 0; k < 18; k++)
    {
        double    ratios[SIM_TRUTH_COUNT / 2];
        char      name[64];
        const int half = k / 9;
        for (int i = 0; i < SIM_TRUTH_COUNT / 2; i++)
        {
            case_t x         = benchmark(2 * i + half);
            x.breakaway      = breakaway[k / 3 % 3];
            x.reference      = rest;
            x.environment_n  = 0.05;
            x.environment_hz = hz[k % 3];
            x.noise_n        = 0.1e-3;
            x.third_s        = 30.0;
            ratios[i]        = ratio(&x, options);
        }
        (void)
            snprintf(name, sizeof name, "rest, %s, %.1f Hz, L x%.1f", half_name[half], hz[k % 3], breakaway[k / 3 % 3]);
        print(name, ratios, SIM_TRUTH_COUNT / 2);
    }
}

/// What a hold comes to over truths, in N.
typedef struct
{
    double mean_rms, most_rms; // of r - F
    double most_travel;        // from the smallest to the largest F
} hold_t;

static void run_hold(const case_t *x, const options_t *options, hold_t *worst)
{
    rig_t      rig;
    double     sum   = 0.0;
    double     least = 1e9;
    double     most  = -1e9;
    const long third = lround(x->third_s / H);
    open_rig(&rig, x, options);
    for (long k = 0; k < 3 * third; k++)
    {
        const double r = x->reference(x->of, (double)k * H);
        const double F = force(&rig);
        if (k >= third)
        {
            sum += (r - F) * (r - F);
            least = fmin(least, F);
            most  = fmax(most, F);
        }
        tick_rig(&rig, x, r);
    }
    close_rig(&rig);
    const double rms = sqrt(sum / (double)(2 * third));
    worst->mean_rms += 2.0 * rms / (double)SIM_TRUTH_COUNT;
    worst->most_rms    = fmax(worst->most_rms, rms);
    worst->most_travel = fmax(worst->most_travel, most - least);
}

/// Two minutes of rest under noise.
static void study_hold(const options_t *options)
{
    static const double noise_mn[]  = {0.0, 0.3, 1.0};
    static const double breakaway[] = {1.0, 0.7, 1.3};
    for (int k = 0; k < 18; k++)
    {
        hold_t    with    = {.mean_rms = 0.0};
        hold_t    without = {.mean_rms = 0.0};
        const int half    = k / 9;
        for (int i = 0; i < SIM_TRUTH_COUNT / 2; i++)
        {
            case_t x    = benchmark(2 * i + half);
            x.breakaway = breakaway[k / 3 % 3];
            x.reference = rest;
            x.noise_n   = 1e-3 * noise_mn[k % 3];
            x.seed      = i + 1;
            x.third_s   = 60.0;
            run_hold(&x, options, &with);
            run_hold(&x, &off, &without);
        }
        printf("hold, %s, noise %.1f mN, L x%.1f: mean RMS %.3f mN, most %.3f, F travels by %.3f; without %.3f, %.3f, "
               "%.3f\n",
               half_name[half],
               noise_mn[k % 3],
               breakaway[k / 3 % 3],
               1e3 * with.mean_rms,
               1e3 * with.most_rms,
               1e3 * with.most_travel,
               1e3 * without.mean_rms,
               1e3 * without.most_rms,
               1e3 * without.most_travel);
        (void)fflush(stdout);
    }
}

/// Steps alone, which teach little, with less breakaway than believed.
static void study_steps(const options_t *options)
{
    static const int    truths[]    = {SIM_TRUTH_paper, SIM_TRUTH_coulomb, SIM_TRUTH_dahl, SIM_TRUTH_armstrong};
    static const double breakaway[] = {0.3, 0.4, 0.5, 0.6, 0.7, 0.85};
    for (int b = 0; b < 6; b++)
    {
        double ratios[32];
        char   name[64];
        for (int i = 0; i < 32; i++)
        {
            case_t x    = benchmark(truths[i / 8]);
            x.breakaway = breakaway[b];
            x.reference = square;
            x.of[1]     = i & 1 ? 0.42 : 0.6;
            x.of[2]     = i & 2 ? 10.0 : 4.0;
            x.noise_n   = i & 4 ? 0.1e-3 : 0.0;
            x.third_s   = 20.0;
            ratios[i]   = ratio(&x, options);
        }
        (void)snprintf(name, sizeof name, "steps alone, L x%.2f", breakaway[b]);
        print(name, ratios, 32);
    }
}

/// A load that lasts: the error 60 s later, without over with.
static void study_loads(const options_t *options)
{
    static const double breakaway[] = {1.0, 0.7, 1.3};
    for (int i = 0; i < 24; i++)
    {
        case_t x      = benchmark(i < 12 ? SIM_TRUTH_paper : SIM_TRUTH_leuven);
        x.breakaway   = breakaway[i / 4 % 3];
        x.noise_n     = i & 1 ? 0.3e-3 : 0.0;
        x.push_n      = i & 2 ? 0.1 : -0.1;
        x.push_s      = 45.0;
        x.push_time_s = 1e9;
        double       without[3], with[3];
        const double ends[3] = {45.0, 65.0, 125.0};
        run_windows(&x, &off, 20.0, ends, without, 3);
        run_windows(&x, options, 20.0, ends, with, 3);
        printf(
            "  %-8s L x%.1f load %+.1f N noise %.1f mN: %.2f times before, %.2f with it, %.2f after 60 s (%.3f mN)\n",
            sim_truth_models[x.truth]->name,
            x.breakaway,
            x.push_n,
            1e3 * x.noise_n,
            without[0] / with[0],
            without[1] / with[1],
            without[2] / with[2],
            1e3 * with[2]);
    }
}

/// A friction term twice as large as learned, for four minutes: what the monitor leaves of the harm in the last two thirds.
static void study_harm(const options_t *options)
{
    double    ratios[SIM_TRUTH_COUNT];
    options_t twice = *options;
    twice.factor    = 2.0;
    for (int truth = 0; truth < SIM_TRUTH_COUNT; truth++)
    {
        case_t x      = benchmark(truth);
        x.third_s     = 80.0;
        ratios[truth] = ratio(&x, &twice);
        printf("  %-18s %.2f times\n", sim_truth_models[truth]->name, ratios[truth]);
    }
    print("twice the friction", ratios, SIM_TRUTH_COUNT);
}

/// Six minutes of the triangle: the error of a period after 1, 2, 4 and 6.
static void study_long(const options_t *options)
{
    for (int truth = 0; truth < SIM_TRUTH_COUNT; truth++)
    {
        const case_t x = benchmark(truth);
        double       rms[4];
        const double ends[4] = {60.0, 120.0, 240.0, 360.0};
        run_windows(&x, options, 20.0, ends, rms, 4);
        printf("  %-18s %.3f, %.3f, %.3f, %.3f mN\n",
               sim_truth_models[truth]->name,
               1e3 * rms[0],
               1e3 * rms[1],
               1e3 * rms[2],
               1e3 * rms[3]);
    }
}

/// Triangles of every rate, on truths and off breakaways, against without and the paper's method.
static void study_rates(const options_t *options)
{
    static const double rates[]     = {0.02, 0.2, 0.4, 0.8, 1.2, 2.0};
    static const int    truths[]    = {SIM_TRUTH_paper,
                                       SIM_TRUTH_coulomb,
                                       SIM_TRUTH_lugre,
                                       SIM_TRUTH_maxwell_slip,
                                       SIM_TRUTH_dahl,
                                       SIM_TRUTH_paper,
                                       SIM_TRUTH_paper};
    static const double breakaway[] = {1.0, 1.0, 1.0, 1.0, 1.0, 0.6, 1.5};
    for (size_t j = 0; j < sizeof truths / sizeof truths[0]; j++)
    {
        printf("  %-14s L x%.1f:", sim_truth_models[truths[j]]->name, breakaway[j]);
        for (size_t i = 0; i < sizeof rates / sizeof rates[0]; i++)
        {
            case_t x          = benchmark(truths[j]);
            x.breakaway       = breakaway[j];
            x.of[2]           = rates[i];
            const double with = run(&x, options);
            printf("  %.2f N/s %.2f (%.2f)", rates[i], run(&x, &off) / with, run(&x, &paper) / with);
        }
        printf("\n");
        (void)fflush(stdout);
    }
}

/// Ten minutes, or minutes=N: the largest |b| in the first minute and in the rest, at rates, breakaways and with 2 % bad readings.
static void study_drift(const options_t *options)
{
    static const double rates[]     = {0.02, 0.2, 0.4, 0.8, 1.2};
    static const double breakaway[] = {0.6, 1.0, 1.5};
    const long          minutes     = lround(drift_minutes);
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
                    const double error = r - force(&rig);
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
static void study_iterative(const options_t *unused)
{
    (void)unused;
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
                errors[k]      = r - force(&rig);
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

/// Takes an argument NAME=VALUE; false for other arguments.
static bool take(options_t *options, const char *argument)
{
    tribo_feedforward_f32_config_t *const config = &options->feedforward;
    const struct
    {
        const char *name;
        float      *value;
    } key[]             = {{"actuator_pole_rad_per_s", &config->actuator_pole_rad_per_s},
                           {"sensor_pole_rad_per_s", &config->sensor_pole_rad_per_s},
                           {"reversal_N", &config->reversal_n},
                           {"presliding_N", &config->presliding_n},
                           {"jump_time_s", &config->jump_time_s},
                           {"jump_lead", &config->jump_lead},
                           {"trust", &config->trust},
                           {"forgetting_per_N", &config->forgetting_per_n},
                           {"still_time_s", &config->still_time_s}};
    const char  *equals = strchr(argument, '=');
    const size_t length = equals != NULL ? (size_t)(equals - argument) : 0u;
    if (length == 0u)
    {
        return false;
    }
    char        *end   = NULL;
    const double value = strtod(equals + 1, &end);
    const bool   all   = *end == '\0' && end != equals + 1;
    if (length == strlen("factor") && strncmp(argument, "factor", length) == 0)
    {
        options->factor = value;
        return all;
    }
    if (length == strlen("minutes") && strncmp(argument, "minutes", length) == 0)
    {
        drift_minutes = value;
        return all;
    }
    for (size_t i = 0; i < sizeof key / sizeof key[0]; i++)
    {
        if (strncmp(argument, key[i].name, length) == 0 && key[i].name[length] == '\0')
        {
            *key[i].value = (float)value;
            return all;
        }
    }
    return false;
}

int main(int argc, char **argv)
{
    static const struct
    {
        const char *name;
        void (*run)(const options_t *options);
    } study[]         = {{"truths", study_truths},
                         {"ratios", study_ratios},
                         {"triangles", study_triangles},
                         {"waves", study_waves},
                         {"across", study_across},
                         {"random", study_random},
                         {"pushes", study_pushes},
                         {"environment", study_environment},
                         {"loads", study_loads},
                         {"rest", study_rest},
                         {"hold", study_hold},
                         {"steps", study_steps},
                         {"long", study_long},
                         {"drift", study_drift},
                         {"rates", study_rates},
                         {"harm", study_harm},
                         {"iterative", study_iterative},
                         {"rivals", study_rivals}};
    options_t options = {.method      = FEEDFORWARD,
                         .feedforward = tribo_feedforward_f32_default(),
                         .factor      = 1.0,
                         .gain        = 1.0};
    for (int i = 1; i < argc; i++)
    {
        bool known = take(&options, argv[i]);
        for (size_t k = 0; k < sizeof study / sizeof study[0]; k++)
        {
            if (strcmp(argv[i], study[k].name) == 0)
            {
                study[k].run(&options);
                known = true;
            }
        }
        if (!known)
        {
            (void)fprintf(stderr, "feedforward_study: what is %s? The file's head says what there is.\n", argv[i]);
            return 2;
        }
    }
    return 0;
}
