// The rig's faults in numbers: the drive with its default bounds on simulated rigs.
//
//     fault_study_f32 healthy HOURS [SEED [N MS]]    false stops of scenarios with 2 mN of noise and breakaway +-20 %, none expected
//     fault_study_f32 broken RUNS [SEED [N MS]]      time from the moment that a sensor breaks to a command of 0
//     fault_study_f32 still RUNS [SEED]              for how long a healthy force stays where it was: so long a frozen sensor is right
//
// Scenarios are those of host_sim/scenarios. N and MS: residual_n and residual_ms in place of their defaults.

#include "app/drive.h"
#include "app/loop.h"
#include "board.h"
#include "loop/loop_config.h"
#include "loop/reference.h"
#include "plant/plant.h"
#include "plant/random.h"
#include "plant/sensor.h"
#include "scenario/config.h"
#include "scenario/plant_config.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NOISE_N 2e-3

static const char *const names[] =
    {"triangle", "asymmetric", "mismatch", "noisy", "sine", "step", "ramp", "sawtooth", "chirp"};

#define NAMES (sizeof names / sizeof names[0])

typedef enum
{
    HEALTHY,
    DETACHED,
    FROZEN,
    REVERSED,
    HALF_SCALE,
    SENSORS
} sensor_t;

static const char *const sensor_names[SENSORS] = {"healthy", "detached", "frozen", "reversed", "half-scale"};

static float    bound_n;
static uint32_t bound_ms;

/// A rig that plays a scenario, and its drive.
typedef struct
{
    common_scenario_t   *scenario;
    sim_config_t         config;
    common_reference_t   reference;
    sim_plant_config_t   plant_config;
    sim_plant_t         *plant;
    sim_sensor_t         sensor;
    unsigned             steps;
    common_loop_config_t loop_config;
    loop_setup_t         loop;
    drive_setup_t        setup;
    board_t              board;
    drive_t              drive;
    uint64_t             tick;
    double               frozen_n;
} rig_t;

/// In [0, 1).
static double uniform(sim_random_t *random)
{
    return (double)(sim_random_bits(random) >> 11) / 9007199254740992.0;
}

static void fail(const char *what)
{
    (void)fprintf(stderr, "fault_study: %s\n", what);
    exit(2);
}

static void scale(common_breakaway_config_t *breakaway, double factor)
{
    breakaway->offset_n *= factor;
    breakaway->slope *= factor;
    breakaway->negative_offset_n.value *= factor;
    breakaway->negative_slope.value *= factor;
    for (unsigned i = 0; i < breakaway->table_count; i++)
    {
        breakaway->table[i].positive_n *= factor;
        breakaway->table[i].negative_n *= factor;
    }
}

static void open_drive(rig_t *rig)
{
    drive_config_t       config = drive_config_default();
    drive_config_error_t error;
    config.period_us    = (uint32_t)lround(1e6 * rig->config.loop.sample_time_s);
    config.full_scale_n = (float)rig->config.loop.limits.full_scale_n;
    config.residual_n   = bound_n;
    config.residual_ms  = bound_ms;
    common_loop_config_fill(&rig->loop_config, &rig->config.loop);
    board_init(&rig->board, 0);
    if (loop_setup(&rig->loop, &rig->loop_config.config, config.full_scale_n) != TRIBO_OK ||
        !drive_setup_init(&rig->setup, &config, &rig->loop.params, &rig->board.port, &error))
    {
        fail("a scenario's loop does not suit the drive");
    }
    drive_init(&rig->drive, &rig->board.port, &rig->setup, DRIVE_FAULT_NONE);
    drive_start(&rig->drive);
}

static void open_rig(rig_t *rig, const char *name, double factor, uint64_t seed)
{
    char           path[512];
    common_error_t error;
    *rig          = (rig_t){.tick = 0};
    rig->scenario = sim_scenario_create();
    (void)snprintf(path, sizeof path, "%s/%s.yaml", TRIBO_SCENARIOS, name);
    if (rig->scenario == NULL || !common_scenario_load(rig->scenario, path, &error) ||
        !common_reference_init(&rig->reference, rig->scenario, &error))
    {
        fail(path);
    }
    rig->config = *sim_scenario_config(rig->scenario);
    scale(&rig->config.plant.friction.breakaway, factor);
    rig->config.sensor.sampling.noise_n    = NOISE_N;
    rig->config.sensor.sampling.noise_seed = seed;
    rig->steps                             = sim_plant_steps(&rig->config);
    rig->plant_config                      = sim_plant_config_of(&rig->config);
    rig->plant = sim_plant_create(&rig->plant_config, sim_truth_models[rig->config.plant.model]);
    if (rig->plant == NULL || !sim_sensor_init(&rig->sensor, &rig->config.sensor.sampling, rig->plant_config.step_s))
    {
        fail("out of memory");
    }
    open_drive(rig);
}

static void close_rig(rig_t *rig)
{
    sim_plant_destroy(rig->plant);
    sim_sensor_free(&rig->sensor);
    common_reference_free(&rig->reference);
    common_scenario_destroy(rig->scenario);
}

static double broken(const rig_t *rig, sensor_t sensor, double filtered_n)
{
    switch (sensor)
    {
    case DETACHED:
        return 0.0;
    case FROZEN:
        return rig->frozen_n;
    case REVERSED:
        return -filtered_n;
    case HALF_SCALE:
        return 0.5 * filtered_n;
    default:
        return filtered_n;
    }
}

static loop_force_t force(const rig_t *rig, double force_n)
{
    return scaling_number((float)force_n, rig->setup.config.full_scale_n);
}

static double newton(const rig_t *rig, loop_force_t x)
{
    return (double)scaling_value(x, rig->setup.config.full_scale_n);
}

/// One tick of the drive with reference `r_n`; false once it has stopped.
static bool advance(rig_t *rig, double r_n, sensor_t sensor)
{
    const double filtered_n = sim_plant_filtered_force(rig->plant);
    const double y_n        = sim_sensor_read(&rig->sensor, broken(rig, sensor, filtered_n));
    board_new_tick(&rig->board);
    rig->board.now_us = (uint32_t)rig->tick * rig->setup.config.period_us;
    rig->board.y      = scaling_number((float)y_n, rig->board.port.sensor.full_units);
    drive_reference(&rig->drive, force(rig, r_n));
    drive_tick(&rig->drive);
    const double u_n = (double)scaling_value(rig->board.command, rig->board.port.output.full_units);
    for (unsigned step = 0; step < rig->steps; step++)
    {
        sim_plant_signals_t unused;
        sim_sensor_push(&rig->sensor, broken(rig, sensor, sim_plant_filtered_force(rig->plant)));
        sim_plant_step(rig->plant, u_n, &unused);
    }
    rig->tick++;
    return rig->drive.state == DRIVE_RUN;
}

static double reference_now(rig_t *rig)
{
    return common_reference_at(&rig->reference, (double)rig->tick * rig->config.loop.sample_time_s);
}

// --- healthy -------------------------------------------------------------------------------------------------------

/// Over all runs of a scenario.
typedef struct
{
    double   simulated_s, max_residual_n;
    uint32_t longest_ms; ///< |y - F^| beyond its bound
    unsigned runs, stops;
} healthy_t;

static void play(healthy_t *seen, const char *name, double factor, uint64_t seed)
{
    static rig_t rig;
    open_rig(&rig, name, factor, seed);
    const uint64_t ticks = (uint64_t)llround(rig.config.duration_s / rig.config.loop.sample_time_s);
    bool           runs  = true;
    while (runs && rig.tick < ticks)
    {
        runs = advance(&rig, reference_now(&rig), HEALTHY);
        const double residual_n =
            fabs(newton(&rig, rig.drive.y) - newton(&rig, rig.drive.signals.compensator.TRIBO_N(force)));
        seen->max_residual_n = fmax(seen->max_residual_n, residual_n);
        seen->longest_ms =
            rig.drive.lasting.residual > seen->longest_ms ? rig.drive.lasting.residual : seen->longest_ms;
    }
    seen->simulated_s += (double)rig.tick * rig.config.loop.sample_time_s;
    seen->runs++;
    seen->stops += !runs;
    if (!runs)
    {
        printf("%s, breakaway x %.3f, seed %llu: %s after %.3f s\n",
               name,
               factor,
               (unsigned long long)seed,
               drive_fault_text(rig.drive.fault),
               (double)rig.tick * rig.config.loop.sample_time_s);
    }
    close_rig(&rig);
}

/// The largest step from rest, in tenths of a newton, that does not stop the drive.
static double largest_step_n(uint64_t seed)
{
    static rig_t rig;
    for (unsigned tenths = 1; tenths < 20u; tenths++)
    {
        open_rig(&rig, "step", 1.0, seed);
        while (rig.tick < 2000u && advance(&rig, 0.1 * tenths, HEALTHY))
        {
        }
        const bool stopped = rig.drive.state != DRIVE_RUN;
        close_rig(&rig);
        if (stopped)
        {
            return 0.1 * (tenths - 1u);
        }
    }
    return 1.9;
}

static int study_healthy(double hours, uint64_t seed)
{
    healthy_t    seen[NAMES] = {{0}};
    sim_random_t random;
    double       total_s = 0.0;
    unsigned     stops   = 0;
    sim_random_seed(&random, seed);
    for (uint64_t run = 0; total_s < 3600.0 * hours; run++)
    {
        const double factor = 0.8 + 0.4 * uniform(&random);
        healthy_t   *of     = &seen[run % NAMES];
        const double before = of->simulated_s;
        play(of, names[run % NAMES], factor, seed + run);
        total_s += of->simulated_s - before;
    }
    printf("%-12s %6s %8s %6s %14s %20s\n",
           "scenario",
           "runs",
           "hours",
           "stops",
           "max |y - F^| N",
           "longest beyond, ms");
    for (unsigned i = 0; i < NAMES; i++)
    {
        const healthy_t *of = &seen[i];
        printf("%-12s %6u %8.2f %6u %14.3f %20lu\n",
               names[i],
               of->runs,
               of->simulated_s / 3600.0,
               of->stops,
               of->max_residual_n,
               (unsigned long)of->longest_ms);
        stops += of->stops;
    }
    printf("%s: %.2f h simulated, %u false stops; bound %g N for %lu ms\n",
           TRIBO_ARITHMETIC,
           total_s / 3600.0,
           stops,
           (double)bound_n,
           (unsigned long)bound_ms);
    printf("a step from rest up to %.1f N does not stop it\n", largest_step_n(seed));
    return stops > 0u;
}

// --- broken --------------------------------------------------------------------------------------------------------

static int compare_times(const void *a, const void *b)
{
    const uint32_t left  = *(const uint32_t *)a;
    const uint32_t right = *(const uint32_t *)b;
    return (left > right) - (left < right);
}

#define RUNS_MAX 2000u
#define LAST_MS  10000u ///< of a run after the sensor has broken

typedef double reference_t(rig_t *rig, double broken_at_s);

/// The triangle goes on.
static double moving(rig_t *rig, double broken_at_s)
{
    (void)broken_at_s;
    return reference_now(rig);
}

/// A step of 0.2 N with the break: what a sensor that froze at the reference needs to show.
static double stepping(rig_t *rig, double broken_at_s)
{
    const double now_s = (double)rig->tick * rig->config.loop.sample_time_s;
    return now_s < broken_at_s ? reference_now(rig) : 0.7;
}

static void study_sensor(sensor_t     sensor,
                         const char  *how,
                         reference_t *r,
                         double       from_s,
                         double       to_s,
                         unsigned     runs,
                         uint64_t     seed)
{
    static rig_t    rig;
    static uint32_t times[RUNS_MAX];
    unsigned        missed = 0;
    sim_random_t    random;
    sim_random_seed(&random, seed);
    for (unsigned run = 0; run < runs; run++)
    {
        const double factor = 0.8 + 0.4 * uniform(&random);
        const double at_s   = from_s + (to_s - from_s) * uniform(&random);
        open_rig(&rig, "triangle", factor, seed + run);
        const uint64_t at = (uint64_t)llround(at_s / rig.config.loop.sample_time_s);
        while (rig.tick < at)
        {
            if (!advance(&rig, r(&rig, at_s), HEALTHY))
            {
                fail("a healthy drive has stopped");
            }
        }
        rig.frozen_n = sim_plant_filtered_force(rig.plant);
        while (rig.tick < at + LAST_MS && advance(&rig, r(&rig, at_s), sensor))
        {
        }
        times[run] = (uint32_t)(rig.tick - at);
        missed += rig.drive.state == DRIVE_RUN;
        close_rig(&rig);
    }
    qsort(times, runs, sizeof times[0], compare_times);
    printf("%-12s %-34s %6u %8lu %8lu %8u\n",
           sensor_names[sensor],
           how,
           runs,
           (unsigned long)times[runs / 2u],
           (unsigned long)times[runs - 1u],
           missed);
}

static int study_broken(unsigned runs, uint64_t seed)
{
    printf("%-12s %-34s %6s %8s %8s %8s\n", "sensor", "when it breaks", "runs", "median", "worst ms", "missed");
    for (sensor_t sensor = DETACHED; sensor < SENSORS; sensor++)
    {
        study_sensor(sensor, "from the start", moving, 0.0, 0.0, runs, seed);
        study_sensor(sensor, "within 0.1 s after the start", moving, 0.0, 0.1, runs, seed);
        study_sensor(sensor, "in the triangle, 0.02 N/s", moving, 1.0, 40.0, runs, seed);
        study_sensor(sensor, "in the triangle, r steps to 0.7 N", stepping, 1.0, 40.0, runs, seed);
    }
    return 0;
}

// --- still ---------------------------------------------------------------------------------------------------------

/// The first tick after `at` in which the force is more than `band_n` from what it was then.
static uint32_t still_ticks(rig_t *rig, uint64_t at, double band_n)
{
    const double was_n = sim_plant_filtered_force(rig->plant);
    while (rig->tick < at + LAST_MS && fabs(sim_plant_filtered_force(rig->plant) - was_n) <= band_n)
    {
        (void)advance(rig, reference_now(rig), HEALTHY);
    }
    return (uint32_t)(rig->tick - at);
}

static int study_still(unsigned runs, uint64_t seed)
{
    static const double bands_n[] = {NOISE_N, 2.0 * NOISE_N, 3.0 * NOISE_N};
    static rig_t        rig;
    static uint32_t     times[RUNS_MAX];
    printf("%-34s %6s %8s %8s\n", "triangle, 0.02 N/s: F within", "runs", "median", "worst ms");
    for (unsigned band = 0; band < sizeof bands_n / sizeof bands_n[0]; band++)
    {
        sim_random_t random;
        sim_random_seed(&random, seed);
        for (unsigned run = 0; run < runs; run++)
        {
            const double   factor = 0.8 + 0.4 * uniform(&random);
            const uint64_t at     = 1000u + (uint64_t)(39000.0 * uniform(&random));
            open_rig(&rig, "triangle", factor, seed + run);
            while (rig.tick < at)
            {
                (void)advance(&rig, reference_now(&rig), HEALTHY);
            }
            times[run] = still_ticks(&rig, at, bands_n[band]);
            close_rig(&rig);
        }
        qsort(times, runs, sizeof times[0], compare_times);
        printf("%.0f mN%29s %6u %8lu %8lu\n",
               1e3 * bands_n[band],
               "",
               runs,
               (unsigned long)times[runs / 2u],
               (unsigned long)times[runs - 1u]);
    }
    return 0;
}

int main(int count, char **arguments)
{
    const drive_config_t normal = drive_config_default();
    bound_n                     = count > 5 ? strtof(arguments[4], NULL) : normal.residual_n;
    bound_ms                    = count > 5 ? (uint32_t)strtoul(arguments[5], NULL, 10) : normal.residual_ms;
    const double        amount  = count > 2 ? strtod(arguments[2], NULL) : 100.0;
    const unsigned long seed    = count > 3 ? strtoul(arguments[3], NULL, 10) : 1ul;
    if (count > 1 && strcmp(arguments[1], "healthy") == 0 && amount > 0.0)
    {
        return study_healthy(amount, seed);
    }
    if (count > 1 && strcmp(arguments[1], "broken") == 0 && amount >= 1.0 && amount <= RUNS_MAX)
    {
        return study_broken((unsigned)amount, seed);
    }
    if (count > 1 && strcmp(arguments[1], "still") == 0 && amount >= 1.0 && amount <= RUNS_MAX)
    {
        return study_still((unsigned)amount, seed);
    }
    (void)fputs(
        "usage: fault_study_f32|q31 healthy HOURS [SEED [N MS]] | broken RUNS [SEED [N MS]] | still RUNS [SEED]\n",
        stderr);
    return 2;
}
