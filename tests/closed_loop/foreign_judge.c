// Judges the feed-forward, by its name and nothing else, on rigs, frictions and waveforms of its own. Prints tables:
//
//     foreign_judge_f32 waves|pushes|load|environment|drift|smooth STRIDE|rates STRIDE|flips N SEED ...
//
// without/with is the RMS of r - F without compensation over that with it.

#include "foreign_loop.h"
#include "foreign_plant.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define STEPS_A_TICK 10
#define PERIOD_S     20.0
#define TWO_PI       6.283185307179586

static const char *const law_names[FOREIGN_LAWS] = {"coulomb", "stribeck", "lugre", "maxwell", "smooth"};

typedef enum
{
    TRIANGLE,
    SINE,
    STEPS,
    STAIRCASE,
    SAWTOOTH,
    WALK,
    NESTED,
    STOP_AND_GO,
    WAVES
} wave_t;

static const char *const wave_names[WAVES] =
    {"triangle", "sine", "steps", "staircase", "sawtooth", "walk", "nested", "stop-and-go"};

static double triangle(double t, double period)
{
    const double phase = fmod(t, period) / period;
    return phase < 0.5 ? 4.0 * phase - 1.0 : 3.0 - 4.0 * phase;
}

/// Straight lines between random points 1.5 s apart.
static double walk(double t, uint64_t which)
{
    double       point[2];
    const double place = t / 1.5;
    for (int i = 0; i < 2; i++)
    {
        uint64_t seed = ((uint64_t)place + (uint64_t)i + 1u) * 0x9e3779b97f4a7c15u + which;
        (void)foreign_random(&seed);
        (void)foreign_random(&seed);
        point[i] = foreign_random(&seed);
    }
    return point[0] + (place - floor(place)) * (point[1] - point[0]);
}

/// -1 to 1.
static double wave_at(wave_t wave, double t)
{
    const double tri = triangle(t, PERIOD_S);
    switch (wave)
    {
    case SINE:
        return sin(TWO_PI * t / 5.0);
    case STEPS:
        return fmod(t, 10.0) < 5.0 ? -1.0 : 1.0;
    case STAIRCASE:
        return floor(tri * 4.0) / 4.0;
    case SAWTOOTH:
        return 2.0 * fmod(t, 4.0) / 4.0 - 1.0;
    case WALK:
        return walk(t, 7u);
    case NESTED:
        return 0.7 * tri + 0.3 * triangle(t, 2.9);
    case STOP_AND_GO:
        return triangle(floor(t / 4.0) * 2.0 + fmin(fmod(t, 4.0), 2.0), PERIOD_S);
    default:
        return tri;
    }
}

/// The truth's deviations and what happens to the arm.
typedef struct
{
    foreign_law_t law;
    double        sliding;
    double        creep;        // N/s
    double        breakaway[2]; // times the model's
    double        noise;        // of y, times L at the mean
    double        believed_noise;
    wave_t        wave;
    double        speed; // of the wave's time; 0: 1
    uint64_t      seed;
    double        push, push_from_s, push_to_s; // times L at the mean
    double        environment, environment_hz;  // times the amplitude
    double        fading_s;                     // L falls to half within this time, from push_from_s on; 0: it stays
} case_t;

static case_t nominal(wave_t wave)
{
    return (case_t){.law = FOREIGN_COULOMB, .sliding = 1.0, .breakaway = {1.0, 1.0}, .wave = wave, .seed = 1u};
}

typedef struct
{
    const foreign_rig_t *rig;
    case_t               given;
    foreign_loop_t      *loop;
    foreign_plant_t      plant;
    double               level; // L at the mean
    long                 tick;
    int                  steps;
} run_t;

static double level_of(const foreign_rig_t *rig)
{
    return rig->offset + rig->slope * (fabs(rig->mean) + 0.5 * rig->amplitude);
}

static void scale_friction(run_t *run, double scale)
{
    for (int d = 0; d < 2; d++)
    {
        run->plant.config.offset[d] = run->rig->offset * run->given.breakaway[d] * scale;
        run->plant.config.slope[d]  = run->rig->slope * run->given.breakaway[d] * scale;
    }
}

static void open_run(run_t               *run,
                     foreign_loop_t      *loop,
                     const foreign_rig_t *rig,
                     const case_t        *given,
                     foreign_method_t     method,
                     int                  steps)
{
    *run = (run_t){.rig = rig, .given = *given, .loop = loop, .level = level_of(rig), .steps = steps};
    const tribo_status_t status = foreign_loop_open(loop, rig, method, given->believed_noise * run->level);
    if (status != TRIBO_OK)
    {
        (void)fprintf(stderr, "%s: refused, %s\n", rig->name, tribo_status_text(status));
        exit(1);
    }
    const foreign_plant_config_t plant = {.actuator_pole = rig->actuator_pole,
                                          .sensor_pole   = rig->sensor_pole,
                                          .inertia       = rig->inertia / rig->stiffness,
                                          .damping       = rig->damping / rig->stiffness,
                                          .law           = given->law,
                                          .sliding       = given->sliding,
                                          .stribeck      = 0.1 * rig->amplitude,
                                          .presliding    = given->law == FOREIGN_LUGRE ? 0.01 * rig->amplitude
                                                                                       : 0.3 * rig->amplitude,
                                          .creep         = given->creep,
                                          .noise         = given->noise * run->level,
                                          .step_s        = rig->sample_time_s / run->steps};
    foreign_plant_open(&run->plant, &plant, given->seed);
    scale_friction(run, 1.0);
}

/// One tick; returns r - F at its start.
static double tick(run_t *run)
{
    const case_t *given = &run->given;
    const double  t     = (double)run->tick * run->rig->sample_time_s;
    const double  speed = given->speed > 0.0 ? given->speed : 1.0;
    const double  r     = run->rig->mean + run->rig->amplitude * wave_at(given->wave, t * speed);
    const double  error = r - foreign_plant_force(&run->plant);
    const double  u     = foreign_loop_step(run->loop, r, foreign_plant_read(&run->plant));
    const double  load  = t >= given->push_from_s && t < given->push_to_s ? given->push * run->level : 0.0;
    if (given->fading_s > 0.0)
    {
        scale_friction(run, 1.0 - 0.5 * fmin(1.0, fmax(0.0, (t - given->push_from_s) / given->fading_s)));
    }
    for (int i = 0; i < run->steps; i++)
    {
        const double at = t + (double)i * run->plant.config.step_s;
        foreign_plant_step(&run->plant,
                           u,
                           load,
                           given->environment * run->rig->amplitude * sin(TWO_PI * given->environment_hz * at));
    }
    run->tick++;
    return error;
}

/// RMS of r - F until time `to_s`.
static double run_to(run_t *run, double to_s)
{
    const long end   = lround(to_s / run->rig->sample_time_s);
    const long begin = run->tick;
    double     sum   = 0.0;
    while (run->tick < end)
    {
        const double error = tick(run);
        sum += error * error;
    }
    return sqrt(sum / (double)(end - begin));
}

static foreign_loop_t the_loop; // large

/// RMS from `from_s` to `to_s`.
static double rms(const foreign_rig_t *rig, const case_t *given, foreign_method_t method, double from_s, double to_s)
{
    run_t run;
    open_run(&run, &the_loop, rig, given, method, STEPS_A_TICK);
    (void)run_to(&run, from_s);
    return run_to(&run, to_s);
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

static void report(const char *name, double *ratios, int count)
{
    int below = 0;
    qsort(ratios, (size_t)count, sizeof *ratios, compare);
    for (int i = 0; i < count; i++)
    {
        below += ratios[i] < 0.9;
    }
    printf("%s: %d cases, least %.2f, 5 %% %.2f, median %.2f, below 0.9: %d\n",
           name,
           count,
           ratios[0],
           ratios[count / 20],
           ratios[count / 2],
           below);
}

static void judge_waves(void)
{
    static double       ratios[WAVES][1000];
    static double       all[10000];
    int                 counts[WAVES] = {0};
    int                 total         = 0;
    static const double scales[][2]   = {{1.0, 1.0}, {0.7, 0.7}, {1.3, 1.3}, {0.75, 1.2}};
    for (int i = 0; i < FOREIGN_RIGS; i++)
    {
        for (int law = 0; law < FOREIGN_SMOOTH; law++)
        {
            for (int variant = 0; variant < 6; variant++)
            {
                printf("%-30s %-9s %d:", foreign_rigs[i].name, law_names[law], variant);
                for (int wave = 0; wave < WAVES; wave++)
                {
                    case_t given         = nominal((wave_t)wave);
                    given.law            = (foreign_law_t)law;
                    given.sliding        = law == FOREIGN_STRIBECK ? 0.85 : 1.0;
                    const double *scale  = scales[variant < 4 ? variant : 0];
                    given.breakaway[0]   = scale[0];
                    given.breakaway[1]   = scale[1];
                    given.noise          = variant == 4 ? 0.002 : variant == 5 ? 0.006 : 0.0;
                    given.believed_noise = given.noise;
                    const double none    = rms(&foreign_rigs[i], &given, FOREIGN_NONE, 20.0, 80.0);
                    const double ratio   = none / rms(&foreign_rigs[i], &given, FOREIGN_FEEDFORWARD, 20.0, 80.0);
                    printf(" %s %.2f", wave_names[wave], ratio);
                    ratios[wave][counts[wave]++] = ratio;
                    all[total++]                 = ratio;
                }
                printf("\n");
                (void)fflush(stdout);
            }
        }
    }
    for (int wave = 0; wave < WAVES; wave++)
    {
        report(wave_names[wave], ratios[wave], counts[wave]);
    }
    report("all", all, total);
}

static void judge_pushes(void)
{
    static const double pushes[] = {0.64, 1.9, 3.2}; // of L: 0.1, 0.3, 0.5 N on the paper's arm
    double              worst    = 0.0;
    int                 above    = 0;
    int                 count    = 0;
    for (int i = 0; i < FOREIGN_RIGS; i++)
    {
        for (int j = 0; j < 12; j++)
        {
            printf("%-30s push %+.2f L, noise %.3f L: after/before",
                   foreign_rigs[i].name,
                   pushes[j % 3] * (j % 2 == 0 ? 1.0 : -1.0),
                   j >= 6 ? 0.002 : 0.0);
            for (int phase = 0; phase < 8; phase++)
            {
                case_t given         = nominal(TRIANGLE);
                given.push           = pushes[j % 3] * (j % 2 == 0 ? 1.0 : -1.0);
                given.push_from_s    = 3.0 * PERIOD_S + PERIOD_S * phase / 8.0 + 0.3;
                given.push_to_s      = given.push_from_s + 1.0;
                given.noise          = j >= 6 ? 0.002 : 0.0;
                given.believed_noise = given.noise;
                run_t run;
                open_run(&run, &the_loop, &foreign_rigs[i], &given, FOREIGN_FEEDFORWARD, STEPS_A_TICK);
                (void)run_to(&run, 2.0 * PERIOD_S);
                const double before = run_to(&run, 3.0 * PERIOD_S);
                (void)run_to(&run, given.push_to_s + 60.0);
                const double ratio = run_to(&run, given.push_to_s + 60.0 + PERIOD_S) / before;
                printf(" %.2f", ratio);
                worst = fmax(worst, ratio);
                above += ratio > 1.5;
                count++;
            }
            printf("\n");
            (void)fflush(stdout);
        }
    }
    printf("pushes: %d, above 1.5: %d, worst %.2f\n", count, above, worst);
}

static void judge_load(void)
{
    static const double scales[] = {1.0, 0.7, 1.3};
    for (int i = 0; i < FOREIGN_RIGS; i++)
    {
        for (int j = 0; j < 6; j++)
        {
            case_t given       = nominal(TRIANGLE);
            given.push         = j % 2 == 0 ? 0.64 : -0.64;
            given.push_from_s  = 3.0 * PERIOD_S;
            given.push_to_s    = 1e9;
            given.breakaway[0] = scales[j / 2];
            given.breakaway[1] = scales[j / 2];
            const double none  = rms(&foreign_rigs[i], &given, FOREIGN_NONE, 120.0, 160.0);
            const double with  = rms(&foreign_rigs[i], &given, FOREIGN_FEEDFORWARD, 120.0, 160.0);
            printf("%-30s load %+.2f L, L x %.1f: without/with %.2f\n",
                   foreign_rigs[i].name,
                   given.push,
                   scales[j / 2],
                   none / with);
            (void)fflush(stdout);
        }
    }
}

static void judge_environment(void)
{
    static double       ratios[200];
    static const double hz[]  = {0.1, 0.37, 1.0};
    int                 count = 0;
    for (int i = 0; i < FOREIGN_RIGS; i++)
    {
        for (int j = 0; j < 12; j++)
        {
            case_t given         = nominal(j < 6 ? TRIANGLE : STOP_AND_GO);
            given.environment    = j % 6 < 3 ? 0.2 : 0.5;
            given.environment_hz = hz[j % 3];
            const double none    = rms(&foreign_rigs[i], &given, FOREIGN_NONE, 20.0, 80.0);
            const double ratio   = none / rms(&foreign_rigs[i], &given, FOREIGN_FEEDFORWARD, 20.0, 80.0);
            printf("%-30s environment %.1f of the swing at %.2f Hz, %s: %.2f\n",
                   foreign_rigs[i].name,
                   given.environment,
                   given.environment_hz,
                   wave_names[given.wave],
                   ratio);
            ratios[count++] = ratio;
            (void)fflush(stdout);
        }
    }
    report("environment", ratios, count);
}

/// L falls to half in a minute.
static void judge_drift(void)
{
    static double ratios[1000];
    int           count = 0;
    for (int i = 0; i < FOREIGN_RIGS; i++)
    {
        for (int j = 0; j < 2 * WAVES; j++)
        {
            case_t given      = nominal((wave_t)(j / 2));
            given.noise       = j % 2 == 0 ? 0.0 : 0.002;
            given.push_from_s = 40.0;
            given.fading_s    = 60.0;
            const double none = rms(&foreign_rigs[i], &given, FOREIGN_NONE, 40.0, 120.0);
            ratios[count++]   = none / rms(&foreign_rigs[i], &given, FOREIGN_FEEDFORWARD, 40.0, 120.0);
            printf("%-30s L to half in 60 s, %s: %.2f\n",
                   foreign_rigs[i].name,
                   wave_names[given.wave],
                   ratios[count - 1]);
            (void)fflush(stdout);
        }
    }
    report("drift", ratios, count);
}

/// Triangles by their rate in units of B a second, with breakaway as believed, less and more: every `stride`th case, after three periods
/// and 40 s. False if a rate has one below 0.9.
static bool judge_rates(long stride)
{
    static const double        rates[]  = {0.13, 1.3, 2.5, 5.0, 7.6, 12.7}; // on the paper's rig 0.02 to 2 N/s
    static const foreign_law_t laws[]   = {FOREIGN_COULOMB, FOREIGN_STRIBECK, FOREIGN_LUGRE, FOREIGN_MAXWELL};
    static const double        scales[] = {1.0, 0.6, 1.5};
    static double              ratios[6][1000];
    int                        counts[6] = {0};
    bool                       good      = true;
    for (long k = 0; k < 6L * FOREIGN_RIGS * 4 * 3; k += stride)
    {
        const long           i     = k % 6;
        const foreign_rig_t *rig   = &foreign_rigs[k / 6 % FOREIGN_RIGS];
        case_t               given = nominal(TRIANGLE);
        given.law                  = laws[k / 6 / FOREIGN_RIGS % 4];
        given.sliding              = given.law == FOREIGN_STRIBECK ? 0.85 : 1.0;
        given.breakaway[0]         = scales[k / 6 / FOREIGN_RIGS / 4];
        given.breakaway[1]         = given.breakaway[0];
        given.speed                = rates[i] * level_of(rig) * PERIOD_S / (4.0 * rig->amplitude);
        const double period        = PERIOD_S / given.speed;
        const double from          = fmax(40.0, 3.0 * period);
        const double to            = from + fmax(40.0, 2.0 * period);
        const double with          = rms(rig, &given, FOREIGN_FEEDFORWARD, from, to);
        const double ratio         = rms(rig, &given, FOREIGN_NONE, from, to) / with;
        printf("%-30s %-9s L x %.1f, %5.2f B/s: %.2f\n",
               rig->name,
               law_names[given.law],
               given.breakaway[0],
               rates[i],
               ratio);
        (void)fflush(stdout);
        ratios[i][counts[i]++] = ratio;
        good                   = good && ratio >= 0.9;
    }
    for (int i = 0; i < 6; i++)
    {
        char name[40];
        (void)snprintf(name, sizeof name, "%.2f B/s", rates[i]);
        report(name, ratios[i], counts[i]);
    }
    return good;
}

/// Friction that creeps where the model's sticks, on axes of 0.3 to 3 kg at 500 Hz to 2 kHz: from Coulomb's to one that is nothing
/// but a lag. Every `stride`th case. False if one is below 0.9 from 100 s on.
static bool judge_smooth(long stride)
{
    static const double masses[] = {0.3, 1.0, 3.0};
    static const double rates[]  = {500.0, 1000.0, 2000.0};
    static const double creeps[] = {0.001, 0.1, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0}; // of the mean rate of r
    static const wave_t waves[]  = {TRIANGLE, SINE, NESTED, WALK};
    static const double ends[]   = {40.0, 100.0, 200.0};
    static double       ratios[3][1000];
    int                 count = 0;
    bool                good  = true;
    for (long k = 0; k < 3L * 3 * 8 * 4; k += stride)
    {
        const double        mass  = masses[k % 3];
        const double        rate  = rates[k / 3 % 3];
        const double        creep = creeps[k / 9 % 8];
        const wave_t        wave  = waves[k / 72];
        const foreign_rig_t rig   = {.name          = "axis",
                                     .sample_time_s = 1.0 / rate,
                                     .actuator_pole = 200.0,
                                     .sensor_pole   = 0.055 * rate,
                                     .inertia       = mass,
                                     .damping       = 240.0 * sqrt(mass),
                                     .stiffness     = 3.2e4,
                                     .offset        = 0.07,
                                     .slope         = 0.3,
                                     .mean          = 5.0,
                                     .amplitude     = 1.0};
        case_t              given = nominal(wave);
        double              none[3];
        run_t               run;
        given.law   = FOREIGN_SMOOTH;
        given.creep = creep * 4.0 * rig.amplitude / PERIOD_S;
        printf("%.1f kg, %4.0f Hz, creep at %7.3f of the rate, %-8s:", mass, rate, creep, wave_names[wave]);
        open_run(&run, &the_loop, &rig, &given, FOREIGN_NONE, 4);
        for (int w = 0; w < 3; w++)
        {
            none[w] = run_to(&run, ends[w]);
        }
        open_run(&run, &the_loop, &rig, &given, FOREIGN_FEEDFORWARD, 4);
        for (int w = 0; w < 3; w++)
        {
            ratios[w][count] = none[w] / run_to(&run, ends[w]);
            good             = good && (w < 2 || ratios[w][count] >= 0.9);
            printf(" %6.2f", ratios[w][count]);
        }
        printf("\n");
        (void)fflush(stdout);
        count++;
    }
    report("until 40 s", ratios[0], count);
    report("until 100 s", ratios[1], count);
    report("until 200 s", ratios[2], count);
    return good;
}

#define MOMENTS 100 // of flips in a period

/// A run and what its loop holds.
typedef struct
{
    run_t           run;
    foreign_state_t state;
} saved_t;

static saved_t saved(const run_t *run)
{
    return (saved_t){.run = *run, .state = run->loop->state};
}

static bool same(const saved_t *a, const saved_t *b)
{
    // NOLINTBEGIN(bugprone-suspicious-memory-comparison,cert-exp42-c,cert-flp37-c): of bits; what differs is played on
    return memcmp(&a->state, &b->state, sizeof a->state) == 0 &&
           memcmp(&a->run.plant, &b->run.plant, sizeof a->run.plant) == 0;
    // NOLINTEND(bugprone-suspicious-memory-comparison,cert-exp42-c,cert-flp37-c)
}

/// The error of the period that begins 60 s after a flip, over `good`; 1 where loop and plant are, soon after it, what they are
/// without it. `at`: the moment of the flip, and 3 s later.
static double flipped(const saved_t at[2], size_t byte, int bit, double good)
{
    run_t run           = at[0].run;
    run.loop->state     = at[0].state;
    const double moment = (double)run.tick * run.rig->sample_time_s;
    ((unsigned char *)&run.loop->state)[byte] ^= (unsigned char)(1u << bit);
    (void)run_to(&run, moment + 3.0);
    const saved_t now = saved(&run);
    if (same(&now, &at[1]))
    {
        return 1.0;
    }
    (void)run_to(&run, moment + 60.0);
    return run_to(&run, moment + 60.0 + PERIOD_S) / good;
}

/// Flips single bits of the state, at some moments of a period of the triangle. False if one does harm and is not said.
static bool judge_flips(long count, uint64_t seed)
{
    static run_t         run;
    static saved_t       at[2];
    const foreign_rig_t *rig    = &foreign_rigs[0];
    const case_t         given  = nominal(TRIANGLE);
    const size_t         size   = sizeof at[0].state;
    long                 silent = 0;
    long                 said   = 0;
    double               worst  = 0.0;
    uint64_t             random = seed * 0x9e3779b97f4a7c15u + 1u;
    open_run(&run, &the_loop, rig, &given, FOREIGN_FEEDFORWARD, 4);
    (void)run_to(&run, 2.0 * PERIOD_S);
    const double good = run_to(&run, 3.0 * PERIOD_S);
    for (long moment = 0; moment < MOMENTS; moment++)
    {
        (void)run_to(&run,
                     3.0 * PERIOD_S + ((double)moment + 0.5 * (1.0 + foreign_random(&random))) * PERIOD_S / MOMENTS);
        at[0] = saved(&run);
        (void)run_to(&run, (double)run.tick * rig->sample_time_s + 3.0);
        at[1] = saved(&run);
        for (long i = moment; i < count; i += MOMENTS)
        {
            const size_t byte  = (size_t)(0.5 * (1.0 + foreign_random(&random)) * (double)size) % size;
            const int    bit   = (int)(4.0 * (1.0 + foreign_random(&random))) % 8;
            const double ratio = flipped(at, byte, bit, good);
            if (!(ratio <= 1.5))
            {
                const bool says = foreign_loop_says(&the_loop, &at[0].state);
                said += says;
                silent += !says;
                worst = fmax(worst, ratio);
                printf("byte %zu of %zu (loop %zu, memory %zu), bit %d, at %.3f s: %.1f times%s\n",
                       byte,
                       size,
                       sizeof at[0].state.state,
                       sizeof at[0].state.memory,
                       bit,
                       (double)at[0].run.tick * rig->sample_time_s,
                       ratio,
                       says ? ", says so" : "");
                (void)fflush(stdout);
            }
        }
        run            = at[0].run;
        the_loop.state = at[0].state;
    }
    printf("flips: %ld, not back after 60 s: %ld silent, %ld said; worst %.1f times\n", count, silent, said, worst);
    return silent == 0;
}

int main(int argc, char **argv)
{
    bool good = true;
    for (int i = 1; i < argc; i++)
    {
        if (strcmp(argv[i], "waves") == 0)
        {
            judge_waves();
        }
        else if (strcmp(argv[i], "pushes") == 0)
        {
            judge_pushes();
        }
        else if (strcmp(argv[i], "load") == 0)
        {
            judge_load();
        }
        else if (strcmp(argv[i], "environment") == 0)
        {
            judge_environment();
        }
        else if (strcmp(argv[i], "drift") == 0)
        {
            judge_drift();
        }
        else if (strcmp(argv[i], "smooth") == 0 && i + 1 < argc)
        {
            good = judge_smooth(strtol(argv[++i], NULL, 10)) && good;
        }
        else if (strcmp(argv[i], "rates") == 0 && i + 1 < argc)
        {
            good = judge_rates(strtol(argv[++i], NULL, 10)) && good;
        }
        else if (strcmp(argv[i], "flips") == 0 && i + 2 < argc)
        {
            good = judge_flips(strtol(argv[i + 1], NULL, 10), strtoull(argv[i + 2], NULL, 10)) && good;
            i += 2;
        }
        else
        {
            (void)fprintf(stderr,
                          "foreign_judge: %s: not one of waves, pushes, load, environment, drift, smooth STRIDE, rates "
                          "STRIDE, flips N SEED\n",
                          argv[i]);
            return 2;
        }
    }
    return good ? 0 : 1;
}
