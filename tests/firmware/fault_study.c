// What stops the drive, in numbers: the drive with its default bounds on simulated rigs, with every method and with and without the
// guard. Truths: the paper's, LuGre, Leuven and Maxwell slip of host_sim, and LuGre and Maxwell slip of own_plant.h. Breakaway is +-20 %
// of what the drive believes, the noise 2 mN.
//
//     fault_study_f32 broken RIGS [SEED]      worst time from the break to a command of 0, as a table in Markdown
//     fault_study_f32 healthy HOURS [SEED]    false stops in HOURS of each method, none expected
//     fault_study_f32 check                   a little of the first two; fails where a target is missed

#include "app/drive.h"
#include "app/loop.h"
#include "board.h"
#include "loop/loop_config.h"
#include "own_plant.h"
#include "plant/plant.h"
#include "plant/random.h"
#include "plant/sensor.h"
#include "scenario/config.h"
#include "scenario/plant_config.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NOISE_N  2e-3
#define RIGS_MAX 2000u

typedef enum
{
    HEALTHY,
    DETACHED,
    REVERSED,
    HALF_SCALE,
    FROZEN,
    MOTOR_OPEN,
    HALF_TORQUE,
    FULL_REVERSE,
    CONTACT_LOST, // from here on an own plant's arm breaks
    SOFT_CONTACT,
    CLAMPED,
    BREAKS
} break_t;

static const char *const break_names[BREAKS] = {"healthy",
                                                "sensor detached",
                                                "sensor reversed",
                                                "sensor at half its scale",
                                                "sensor frozen, but noisy",
                                                "motor open",
                                                "motor at half its torque",
                                                "command wire open: full reverse",
                                                "contact lost",
                                                "contact at a tenth of its stiffness",
                                                "arm clamped"};

typedef struct
{
    const char     *name;
    common_method_t method;
    bool            guarded;
} method_t;

static const method_t methods[] = {{"off", COMMON_METHOD_OFF, false},
                                   {"paper", COMMON_METHOD_PAPER, false},
                                   {"paper, guard", COMMON_METHOD_PAPER, true},
                                   {"feed-forward", COMMON_METHOD_FEEDFORWARD, false},
                                   {"feed-forward, guard", COMMON_METHOD_FEEDFORWARD, true}};

#define METHODS (sizeof methods / sizeof methods[0])

typedef enum
{
    OWN_LUGRE,
    OWN_MAXWELL,
    PAPER,
    LUGRE,
    LEUVEN,
    MAXWELL,
    TRUTHS
} truth_t;

static const char *const truth_names[TRUTHS] =
    {"own LuGre", "own Maxwell slip", "paper", "LuGre", "Leuven", "Maxwell slip"};

static const sim_truth_number_t host_truths[TRUTHS] = {[PAPER]   = SIM_TRUTH_paper,
                                                       [LUGRE]   = SIM_TRUTH_lugre,
                                                       [LEUVEN]  = SIM_TRUTH_leuven,
                                                       [MAXWELL] = SIM_TRUTH_maxwell_slip};

/// A plant and its drive.
typedef struct
{
    common_scenario_t   *scenario;
    sim_config_t         config;
    sim_plant_config_t   plant_config;
    sim_plant_t         *plant; // null: `own`
    own_plant_t          own;
    unsigned             steps;
    sim_sensor_t         sensor;
    common_loop_config_t loop_config;
    loop_setup_t         loop;
    loop_memory_t        memory;
    drive_setup_t        setup;
    board_t              board;
    drive_t              drive;
    uint64_t             tick;
    break_t              broken;
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

// --- a rig ---------------------------------------------------------------------------------------------------------

static tribo_status_t set_up_loop(rig_t *rig, float full_scale_n)
{
    const tribo_force_loop_f32_config_t whole =
        tribo_loop_with_parts(&rig->loop_config.parts, &rig->loop.feedforward, &rig->loop.guard);
    return loop_setup(&rig->loop, &whole, full_scale_n);
}

static void open_drive(rig_t *rig, const method_t *method)
{
    drive_config_t       config = drive_config_default();
    drive_config_error_t error;
    config.full_scale_n                   = BOARD_FULL_SCALE_N;
    rig->config.loop.compensator.method   = method->method;
    rig->config.loop.compensator.guard.on = method->guarded;
    common_loop_config_fill(&rig->loop_config, &rig->config.loop);
    board_init(&rig->board, 0);
    if (set_up_loop(rig, config.full_scale_n) != TRIBO_OK ||
        !drive_setup_init(&rig->setup, &config, &rig->loop.params, &rig->board.port, &error))
    {
        fail("the loop does not suit the drive");
    }
    drive_init(&rig->drive, &rig->board.port, &rig->setup, DRIVE_FAULT_NONE);
    loop_forget(&rig->loop.params, &rig->memory);
    drive_attach(&rig->drive, &rig->memory);
    drive_start(&rig->drive);
}

static void open_rig(rig_t *rig, const method_t *method, truth_t truth, double factor, uint64_t seed)
{
    *rig                                = (rig_t){.scenario = sim_scenario_create()};
    rig->own                            = own_plant(truth == OWN_MAXWELL ? OWN_PLANT_MAXWELL : OWN_PLANT_LUGRE, factor);
    rig->config                         = *sim_scenario_config(rig->scenario);
    rig->config.sensor.sampling.noise_n = NOISE_N;
    rig->config.sensor.sampling.noise_seed = seed;
    open_drive(rig, method);
    if (truth >= PAPER && truth < TRUTHS)
    {
        rig->config.plant.model = host_truths[truth];
        rig->config.plant.friction.breakaway.offset_n *= factor;
        rig->config.plant.friction.breakaway.slope *= factor;
        rig->steps        = sim_plant_steps(&rig->config);
        rig->plant_config = sim_plant_config_of(&rig->config);
        rig->plant        = sim_plant_create(&rig->plant_config, sim_truth_models[rig->config.plant.model]);
    }
    if ((truth >= PAPER && rig->plant == NULL) || !sim_sensor_init(&rig->sensor, &rig->config.sensor.sampling, 1e-3))
    {
        fail("out of memory");
    }
}

static void close_rig(rig_t *rig)
{
    sim_plant_destroy(rig->plant);
    sim_sensor_free(&rig->sensor);
    common_scenario_destroy(rig->scenario);
}

/// F behind the sensor's pole.
static double filtered_n(const rig_t *rig)
{
    return rig->plant != NULL ? sim_plant_filtered_force(rig->plant) : rig->own.filtered_n;
}

static void break_rig(rig_t *rig, break_t what)
{
    rig->broken        = what;
    rig->frozen_n      = filtered_n(rig);
    rig->own.stiffness = what == CONTACT_LOST   ? 0.0
                         : what == SOFT_CONTACT ? 0.1 * rig->own.stiffness
                                                : rig->own.stiffness;
    rig->own.clamped   = what == CLAMPED;
}

static double shown_n(const rig_t *rig)
{
    switch (rig->broken)
    {
    case DETACHED:
        return 0.0;
    case FROZEN:
        return rig->frozen_n;
    case REVERSED:
        return -filtered_n(rig);
    case HALF_SCALE:
        return 0.5 * filtered_n(rig);
    default:
        return filtered_n(rig);
    }
}

#define FULL_N 2.0 // what the motor can

/// What reaches the motor of a command.
static double driven_n(const rig_t *rig, double u_n)
{
    switch (rig->broken)
    {
    case MOTOR_OPEN:
        return 0.0;
    case HALF_TORQUE:
        return 0.5 * u_n;
    case FULL_REVERSE:
        return -FULL_N;
    default:
        return u_n;
    }
}

static void step_plant(rig_t *rig, double u_n)
{
    if (rig->plant == NULL)
    {
        own_plant_step(&rig->own, driven_n(rig, u_n), 1e-3);
        return;
    }
    for (unsigned step = 0; step < rig->steps; step++)
    {
        sim_plant_signals_t unused;
        sim_plant_step(rig->plant, driven_n(rig, u_n), &unused);
    }
}

/// One tick of the drive with reference `r_n`; false once it has stopped.
static bool advance(rig_t *rig, double r_n)
{
    const double full_n = (double)BOARD_FULL_SCALE_N;
    board_new_tick(&rig->board);
    rig->board.now_us = (uint32_t)(rig->tick * rig->setup.config.period_us);
    rig->board.y      = board_force(sim_sensor_read(&rig->sensor, shown_n(rig)));
    drive_reference(&rig->drive, board_force(r_n));
    drive_tick(&rig->drive);
    step_plant(rig, (double)scaling_value(rig->board.command, (float)full_n));
    rig->tick++;
    return rig->drive.state == DRIVE_RUN;
}

// --- broken --------------------------------------------------------------------------------------------------------

#define LAST_MS 10000u // of a run after the break

/// At `level_n` the reference stands still, or moves by 0.1 N at 20 mN/s.
static double reference_n(const rig_t *rig, double level_n, bool moves)
{
    const double phase = fmod((double)rig->tick * 1e-3, 10.0) / 5.0;
    const double away  = moves ? 0.1 * (phase < 1.0 ? phase : 2.0 - phase) : 0.0;
    return level_n < 0.0 ? level_n - away : level_n + away;
}

/// The result of some rigs with the same break.
typedef struct
{
    unsigned rigs, never;
    uint32_t worst_ms;
} found_t;

/// From `low_n` to `high_n`, of either sign.
static found_t play_broken(const method_t *method,
                           break_t         what,
                           double          low_n,
                           double          high_n,
                           unsigned        rigs,
                           uint64_t        seed)
{
    static rig_t rig;
    found_t      found = {.rigs = rigs};
    sim_random_t random;
    sim_random_seed(&random, seed);
    for (unsigned i = 0; i < rigs; i++)
    {
        const truth_t  truth   = what >= CONTACT_LOST ? (truth_t)(i % PAPER) : (truth_t)(i % TRUTHS);
        const double   factor  = 0.8 + 0.4 * uniform(&random);
        const double   size_n  = low_n + (high_n - low_n) * uniform(&random);
        const double   level_n = uniform(&random) < 0.5 ? size_n : -size_n;
        const bool     moves   = uniform(&random) < 0.5;
        const uint64_t at      = 2000u + (uint64_t)(10000.0 * uniform(&random));
        open_rig(&rig, method, truth, factor, seed + i);
        while (rig.tick < at)
        {
            if (!advance(&rig, reference_n(&rig, level_n, moves)))
            {
                fail("a healthy drive has stopped");
            }
        }
        break_rig(&rig, what);
        while (rig.tick < at + LAST_MS && advance(&rig, reference_n(&rig, level_n, moves)))
        {
        }
        const uint32_t took = (uint32_t)(rig.tick - at);
        found.worst_ms      = took > found.worst_ms ? took : found.worst_ms;
        found.never += rig.drive.state == DRIVE_RUN;
        close_rig(&rig);
    }
    return found;
}

/// A row of the table, and the target in ms; 0: none.
typedef struct
{
    break_t  what;
    double   low_n, high_n;
    uint32_t target_ms;
} row_t;

static const row_t rows[] = {{DETACHED, 0.3, 0.8, 120},
                             {REVERSED, 0.3, 0.8, 120},
                             {HALF_SCALE, 0.3, 0.8, 120},
                             {CONTACT_LOST, 0.3, 0.8, 120},
                             {MOTOR_OPEN, 0.3, 0.8, 120},
                             {DETACHED, 0.15, 0.15, 150},
                             {CONTACT_LOST, 0.15, 0.15, 150},
                             {REVERSED, 0.15, 0.15, 0},
                             {HALF_SCALE, 0.15, 0.15, 0},
                             {MOTOR_OPEN, 0.15, 0.15, 0},
                             {HALF_TORQUE, 0.3, 0.8, 0},
                             {FULL_REVERSE, 0.3, 0.8, 0},
                             {SOFT_CONTACT, 0.3, 0.8, 0},
                             {CLAMPED, 0.3, 0.8, 0},
                             {FROZEN, 0.3, 0.8, 0}};

static void print_found(const found_t *found)
{
    if (found->never == 0u)
    {
        printf(" %lu |", (unsigned long)found->worst_ms);
    }
    else if (found->never == found->rigs)
    {
        printf(" never |");
    }
    else
    {
        printf(" never: %u of %u |", found->never, found->rigs);
    }
}

/// Misses of a target, counting cells; all rows, or those with a target.
static unsigned study_broken(unsigned rigs, uint64_t seed, bool targets_only)
{
    unsigned missed = 0;
    printf("| %s, r in N |", TRIBO_ARITHMETIC);
    for (unsigned m = 0; m < METHODS; m++)
    {
        printf(" %s |", methods[m].name);
    }
    printf(" target |\n|---|");
    for (unsigned m = 0; m <= METHODS; m++)
    {
        printf("---|");
    }
    printf("\n");
    for (unsigned i = 0; i < sizeof rows / sizeof rows[0]; i++)
    {
        const row_t *row = &rows[i];
        if (targets_only && row->target_ms == 0u)
        {
            continue;
        }
        printf(row->low_n < row->high_n ? "| %s, %g to %g |" : "| %s, %g |",
               break_names[row->what],
               row->low_n,
               row->high_n);
        for (unsigned m = 0; m < METHODS; m++)
        {
            const found_t found = play_broken(&methods[m], row->what, row->low_n, row->high_n, rigs, seed);
            print_found(&found);
            missed += row->target_ms > 0u && (found.never > 0u || found.worst_ms > row->target_ms);
            (void)fflush(stdout);
        }
        printf(row->target_ms > 0u ? " %lu |\n" : " |\n", (unsigned long)row->target_ms);
    }
    return missed;
}

// --- healthy -------------------------------------------------------------------------------------------------------

#define PART_MS 10000u // of one kind of reference
#define PARTS   60u    // of a run: ten minutes

typedef enum
{
    STEPS,
    WIDE_STEPS,
    TRIANGLE,
    WIDE_TRIANGLE,
    HOLD,
    SINE,
    KINDS
} kind_t;

static const char *const kind_names[KINDS] =
    {"steps of 0.6 N", "steps of +-0.8 N", "triangle", "triangle of +-0.8 N", "hold", "sine"};

/// A part of a run: between two forces, back and forth.
typedef struct
{
    kind_t kind;
    double low_n, high_n, period_s;
} part_t;

static part_t part_of(sim_random_t *random)
{
    part_t part = {.kind     = (kind_t)(uniform(random) * (double)KINDS),
                   .low_n    = -0.8,
                   .high_n   = 0.8,
                   .period_s = 1.0 + 9.0 * uniform(random)};
    if (part.kind == STEPS)
    {
        part.low_n  = -0.9 + 1.2 * uniform(random);
        part.high_n = part.low_n + 0.6;
    }
    else if (part.kind != WIDE_STEPS && part.kind != WIDE_TRIANGLE)
    {
        part.low_n  = -0.9 + 1.8 * uniform(random);
        part.high_n = part.kind == HOLD ? part.low_n : -0.9 + 1.8 * uniform(random);
    }
    return part;
}

static double part_n(const part_t *part, double t_s)
{
    const double phase = fmod(t_s, part->period_s) / part->period_s;
    const double rise  = part->kind == STEPS || part->kind == WIDE_STEPS ? (phase < 0.5 ? 0.0 : 1.0)
                         : part->kind == SINE                            ? 0.5 - 0.5 * cos(6.283185307179586 * phase)
                                              : (phase < 0.5 ? 2.0 * phase : 2.0 - 2.0 * phase);
    return part->low_n + (part->high_n - part->low_n) * rise;
}

/// The result of all runs of a method.
typedef struct
{
    double   hours;
    uint32_t residual_ms, tracking_ms; // longest beyond the bound
    unsigned stops;
} healthy_t;

static void play_healthy(healthy_t *seen, const method_t *method, truth_t truth, double factor, uint64_t seed)
{
    static rig_t rig;
    sim_random_t random;
    sim_random_seed(&random, seed);
    open_rig(&rig, method, truth, factor, seed);
    bool runs = true;
    for (unsigned i = 0; runs && i < PARTS; i++)
    {
        const part_t part = part_of(&random);
        for (unsigned ms = 0; runs && ms < PART_MS; ms++)
        {
            runs                      = advance(&rig, part_n(&part, ms * 1e-3));
            const faults_loop_t *last = &rig.drive.lasting.loop;
            seen->residual_ms         = last->residual > seen->residual_ms ? last->residual : seen->residual_ms;
            seen->tracking_ms         = last->tracking > seen->tracking_ms ? last->tracking : seen->tracking_ms;
        }
        if (!runs)
        {
            printf("%s, %s, breakaway x %.3f, seed %llu: %s in %s from %.2f to %.2f N\n",
                   method->name,
                   truth_names[truth],
                   factor,
                   (unsigned long long)seed,
                   drive_fault_text(rig.drive.fault),
                   kind_names[part.kind],
                   part.low_n,
                   part.high_n);
        }
    }
    seen->hours += (double)rig.tick / 3.6e6;
    seen->stops += !runs;
    close_rig(&rig);
}

static unsigned study_healthy(double hours, uint64_t seed)
{
    healthy_t    seen[METHODS] = {{0}};
    sim_random_t random;
    unsigned     stops = 0;
    sim_random_seed(&random, seed);
    for (uint64_t run = 0; seen[METHODS - 1].hours < hours; run++)
    {
        const double factor = 0.8 + 0.4 * uniform(&random);
        for (unsigned m = 0; m < METHODS; m++)
        {
            play_healthy(&seen[m], &methods[m], (truth_t)(run % TRUTHS), factor, seed + run);
        }
    }
    printf("| %s | hours | false stops | longest beyond the residual's bound, ms | beyond tracking's, ms |\n",
           TRIBO_ARITHMETIC);
    printf("|---|---|---|---|---|\n");
    for (unsigned m = 0; m < METHODS; m++)
    {
        printf("| %s | %.2f | %u | %lu | %lu |\n",
               methods[m].name,
               seen[m].hours,
               seen[m].stops,
               (unsigned long)(seen[m].residual_ms / FAULTS_RISE_RESIDUAL),
               (unsigned long)(seen[m].tracking_ms / FAULTS_RISE_LOOP));
        stops += seen[m].stops;
    }
    return stops;
}

// --- the program ---------------------------------------------------------------------------------------------------

#define CHECK_RIGS  6u   // one of each truth
#define CHECK_HOURS 0.16 // a run of each method

static int check(void)
{
    const unsigned missed = study_broken(CHECK_RIGS, 1, true);
    const unsigned stops  = study_healthy(CHECK_HOURS, 1);
    printf("%u targets missed, %u false stops\n", missed, stops);
    return missed > 0u || stops > 0u;
}

int main(int count, char **arguments)
{
    const char *const   what   = count > 1 ? arguments[1] : "";
    const double        amount = count > 2 ? strtod(arguments[2], NULL) : 0.0;
    const unsigned long seed   = count > 3 ? strtoul(arguments[3], NULL, 10) : 1ul;
    const bool          rigs   = amount >= 1.0 && amount <= RIGS_MAX;
    if (strcmp(what, "check") == 0)
    {
        return check();
    }
    if (strcmp(what, "healthy") == 0 && amount > 0.0)
    {
        return study_healthy(amount, seed) > 0u;
    }
    if (strcmp(what, "broken") == 0 && rigs)
    {
        return study_broken((unsigned)amount, seed, false) > 0u;
    }
    (void)fputs("usage: fault_study_f32|q31 broken RIGS [SEED] | healthy HOURS [SEED] | check\n", stderr);
    return 2;
}
