// What stops the drive, in numbers, on the plants of own_plant.h. Broken are rigs like the paper's with the default bounds, with every
// method and with and without the guard; the others have other frictions, sizes and sample times, and params that a client could write.
//
//     loop_study_f32 broken RIGS      worst time from the break to a command of 0, as a table in Markdown
//     loop_study_f32 swing RIGS       time until a loop that a client's tuning makes swing is stopped, and those that swing on: from the
//                                     first turn of y by 0.3 of 4 N, or of u by 1 N, and from where u first comes near a limit
//     loop_study_f32 healthy HOURS    false stops of 75 rigs, HOURS in all
//     loop_study_f32 check            a little of all, contacts that are loose in between, and rigs that are stopped and started every
//                                     50 ms; fails where a target is missed

#include "app/params.h"
#include "board.h"
#include "own_plant.h"
#include "plant/random.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RIGS 75u

typedef enum
{
    CONTROLLER_PAPER, // for 1 ms alone
    CONTROLLER_SLOW,  // PI
    CONTROLLER_QUICK
} controller_t;

typedef struct
{
    own_plant_friction_t friction;
    double               size; // times the paper's forces
    uint32_t             period_us;
    controller_t         controller;
    uint32_t             method; // PARAMS_METHOD_
    bool                 guarded;
    double               factor; // of breakaway to what the drive believes
    double               noise_n, step_n;
    uint64_t             seed;
} kind_t;

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
    CONTACT_LOST,
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
                                                "arm clamped"};

/// A plant and its drive.
typedef struct
{
    kind_t        kind;
    own_plant_t   plant;
    sim_random_t  random;
    params_t      params[2];
    unsigned      used; // of the two
    loop_memory_t memory;
    board_t       board;
    drive_t       drive;
    uint64_t      tick;
    double        h_s;
    break_t       broken;
    double        frozen_n;
    double        reference; // of the paper's rig, as all forces here
} rig_t;

static void fail(const char *what)
{
    (void)fprintf(stderr, "loop_study: %s\n", what);
    exit(2);
}

static double uniform(sim_random_t *random)
{
    return (double)(sim_random_bits(random) >> 11) / 9007199254740992.0;
}

static double gauss(sim_random_t *random)
{
    double sum = 0.0;
    for (int i = 0; i < 12; i++)
    {
        sum += uniform(random);
    }
    return sum - 6.0;
}

// --- a rig ---------------------------------------------------------------------------------------------------------

static void put(params_set_t *set, uint32_t word, double value)
{
    const float number = (float)value;
    memcpy((char *)set + 4u * word, &number, sizeof number);
}

static void times(params_set_t *set, uint32_t word, double factor)
{
    put(set, word, (double)params_number(set, word) * factor);
}

/// (kp + ki / s) with its pole at -0.002 rad/s.
static void put_pi(params_set_t *set, double kp, double ki, double h_s)
{
    const double leak = 0.002 * h_s;
    const double last = kp * leak + ki * h_s;
    set->sections[0] =
        (tribo_biquad_f32_section_t){(float)kp, (float)(kp + last), (float)last, (float)(1.0 + leak), (float)leak};
    const uint32_t one = 1;
    memcpy((char *)set + 4u * (uint32_t)PARAMS_SECTION_COUNT, &one, sizeof one);
}

static params_set_t set_of(const kind_t *kind)
{
    static const uint32_t forces[] = {DRIVE_CONFIG_residual_n,
                                      DRIVE_CONFIG_tracking_n,
                                      DRIVE_CONFIG_full_scale_n,
                                      PARAMS_INPUT_MAX,
                                      PARAMS_U_MIN,
                                      PARAMS_U_MAX,
                                      PARAMS_V0,
                                      PARAMS_BREAKAWAY_OFFSET,
                                      PARAMS_BREAKAWAY_NEGATIVE_OFFSET,
                                      PARAMS_INERTIA,
                                      PARAMS_DAMPING,
                                      PARAMS_STIFFNESS,
                                      PARAMS_GUARD_TURN,
                                      PARAMS_GUARD_STRAY};
    params_set_t          set      = params_default();
    const double          h_s      = 1e-6 * kind->period_us;
    for (size_t i = 0; i < sizeof forces / sizeof forces[0]; i++)
    {
        times(&set, forces[i], kind->size);
    }
    put(&set, PARAMS_SAMPLE_TIME, h_s);
    set.drive.period_us = kind->period_us;
    set.drive.late_us   = kind->period_us / 20u;
    set.drive.budget_us = kind->period_us / 4u;
    set.method          = kind->method;
    set.guard_on        = kind->guarded;
    if (kind->controller != CONTROLLER_PAPER)
    {
        const double ki = kind->controller == CONTROLLER_SLOW ? 12.0 : 30.0;
        put_pi(&set, ki / 55.0, ki, h_s);
    }
    return set;
}

/// Takes a set over as a client does. False if it is refused.
static bool apply(rig_t *rig, const params_set_t *set)
{
    params_error_t  error;
    params_t *const next = &rig->params[1u - rig->used];
    next->set            = *set;
    if (!params_make(next, &rig->board.port, &error))
    {
        return false;
    }
    rig->used = 1u - rig->used;
    return true;
}

static void open_rig(rig_t *rig, const kind_t *kind)
{
    *rig = (rig_t){.kind = *kind, .plant = own_plant(kind->friction, kind->factor), .h_s = 1e-6 * kind->period_us};
    sim_random_seed(&rig->random, kind->seed);
    board_init(&rig->board, 0);
    rig->board.tick_us                = kind->period_us / 50u;
    const params_set_t set            = set_of(kind);
    rig->board.port.sensor.full_units = set.drive.full_scale_n;
    rig->board.port.output.full_units = set.drive.full_scale_n;
    if (!apply(rig, &set))
    {
        fail("the rig's own params are refused");
    }
    drive_init(&rig->drive, &rig->board.port, &rig->params[rig->used].drive, DRIVE_FAULT_NONE);
    loop_forget(&rig->params[rig->used].loop.params, &rig->memory);
    drive_attach(&rig->drive, &rig->memory);
    drive_start(&rig->drive);
}

static loop_force_t force_of(const rig_t *rig, double of_paper)
{
    return scaling_number((float)(of_paper * rig->kind.size), rig->drive.setup->config.full_scale_n);
}

static double of_paper(const rig_t *rig, loop_force_t force)
{
    return (double)scaling_value(force, rig->drive.setup->config.full_scale_n) / rig->kind.size;
}

static void break_rig(rig_t *rig, break_t what)
{
    rig->broken          = what;
    rig->frozen_n        = rig->plant.filtered_n;
    rig->plant.stiffness = what == CONTACT_LOST ? 0.0 : rig->plant.stiffness;
    rig->plant.clamped   = what == CLAMPED;
}

static double sensed(const rig_t *rig)
{
    switch (rig->broken)
    {
    case DETACHED:
        return 0.0;
    case FROZEN:
        return rig->frozen_n;
    case REVERSED:
        return -rig->plant.filtered_n;
    case HALF_SCALE:
        return 0.5 * rig->plant.filtered_n;
    default:
        return rig->plant.filtered_n;
    }
}

#define FULL_N 2.0 // what the motor can

/// What reaches the motor of a command.
static double driven(const rig_t *rig, double u)
{
    switch (rig->broken)
    {
    case MOTOR_OPEN:
        return 0.0;
    case HALF_TORQUE:
        return 0.5 * u;
    case FULL_REVERSE:
        return -FULL_N;
    default:
        return u;
    }
}

static double shown(rig_t *rig)
{
    const double y = sensed(rig) + (rig->kind.noise_n > 0.0 ? rig->kind.noise_n * gauss(&rig->random) : 0.0);
    return rig->kind.step_n > 0.0 ? rig->kind.step_n * floor(y / rig->kind.step_n + 0.5) : y;
}

/// False once the drive has stopped.
static bool advance(rig_t *rig)
{
    board_new_tick(&rig->board);
    rig->board.now_us = (uint32_t)(rig->tick * rig->kind.period_us);
    rig->board.y      = force_of(rig, shown(rig));
    drive_reference(&rig->drive, force_of(rig, rig->reference));
    drive_tick(&rig->drive);
    own_plant_step(&rig->plant, driven(rig, of_paper(rig, rig->board.command)), rig->h_s);
    rig->tick++;
    return rig->drive.state != DRIVE_FAULT;
}

static bool advance_for(rig_t *rig, double time_s)
{
    const uint64_t end = rig->tick + (uint64_t)(time_s / rig->h_s + 0.5);
    bool           on  = true;
    while (on && rig->tick < end)
    {
        on = advance(rig);
    }
    return on;
}

/// The n-th of many.
static kind_t kind_of(uint64_t n, uint64_t seed)
{
    static const double   sizes[]   = {0.05, 0.3, 1.0, 4.0, 30.0, 250.0};
    static const uint32_t periods[] = {1000, 2000, 1000, 500, 1000, 250, 1000, 100};
    static const uint32_t methods[] = {PARAMS_METHOD_FEEDFORWARD, PARAMS_METHOD_PAPER, PARAMS_METHOD_OFF};
    sim_random_t          random;
    sim_random_seed(&random, seed + n);
    kind_t kind     = {.friction  = (own_plant_friction_t)(n % OWN_PLANT_FRICTIONS),
                       .size      = sizes[n % 6u],
                       .period_us = periods[n / 3u % 8u],
                       .method    = methods[n % 3u],
                       .guarded   = n % 7u != 0u,
                       .factor    = 0.8 + 0.4 * uniform(&random),
                       .noise_n   = n % 4u == 0u ? 0.0 : 4e-3 * uniform(&random),
                       .step_n    = n % 5u < 2u ? 4e-3 * uniform(&random) : 0.0,
                       .seed      = seed + n};
    kind.controller = kind.period_us == 1000u && n % 5u != 0u ? CONTROLLER_PAPER
                      : n % 2u == 0u                          ? CONTROLLER_SLOW
                                                              : CONTROLLER_QUICK;
    return kind;
}

static void print_kind(const rig_t *rig)
{
    static const char *const frictions[]   = {"LuGre", "Maxwell slip", "Coulomb", "servo"};
    static const char *const controllers[] = {"paper", "slow PI", "quick PI"};
    printf("%s x %.2f, %g N, %lu us, %s, method %lu%s, seed %llu: ",
           frictions[rig->kind.friction],
           rig->kind.factor,
           2.0 * rig->kind.size,
           (unsigned long)rig->kind.period_us,
           controllers[rig->kind.controller],
           (unsigned long)rig->kind.method,
           rig->kind.guarded ? ", guard" : "",
           (unsigned long long)rig->kind.seed);
}

// --- broken --------------------------------------------------------------------------------------------------------

#define BROKEN_S 10.0 // of a run after the break
#define NOISE_N  2e-3

static const struct
{
    const char *name;
    uint32_t    method;
    bool        guarded;
} set_ups[] = {{"off", PARAMS_METHOD_OFF, false},
               {"paper", PARAMS_METHOD_PAPER, false},
               {"paper, guard", PARAMS_METHOD_PAPER, true},
               {"feed-forward", PARAMS_METHOD_FEEDFORWARD, false},
               {"feed-forward, guard", PARAMS_METHOD_FEEDFORWARD, true}};

#define SET_UPS (sizeof set_ups / sizeof set_ups[0])

/// A row of the table, and the target in ms; 0: none.
typedef struct
{
    break_t what;
    double  low_n, high_n;
    double  target_ms;
} row_t;

static const row_t rows[] = {{DETACHED, 0.3, 0.8, 120},
                             {REVERSED, 0.3, 0.8, 120},
                             {HALF_SCALE, 0.3, 0.8, 120},
                             {CONTACT_LOST, 0.3, 0.8, 120},
                             {MOTOR_OPEN, 0.3, 0.8, 120},
                             {DETACHED, 0.15, 0.15, 150},
                             {CONTACT_LOST, 0.15, 0.15, 150},
                             {HALF_TORQUE, 0.3, 0.8, 0},
                             {FULL_REVERSE, 0.3, 0.8, 0},
                             {CLAMPED, 0.3, 0.8, 0},
                             {FROZEN, 0.3, 0.8, 0}};

/// The result of some rigs with the same break.
typedef struct
{
    unsigned never;
    double   worst_ms;
} found_t;

/// At `level` the reference stands still, or moves by 0.1 N at 20 mN/s. False once the drive has stopped.
static bool advance_at(rig_t *rig, double level, bool moves)
{
    const double phase = fmod((double)rig->tick * rig->h_s, 10.0) / 5.0;
    const double away  = moves ? 0.1 * (phase < 1.0 ? phase : 2.0 - phase) : 0.0;
    rig->reference     = level < 0.0 ? level - away : level + away;
    return advance(rig);
}

static void play_broken(found_t *found, const row_t *row, unsigned set_up, uint64_t n)
{
    static rig_t rig;
    sim_random_t random;
    sim_random_seed(&random, n);
    const kind_t kind  = {.friction  = (own_plant_friction_t)(n % OWN_PLANT_FRICTIONS),
                          .size      = 1.0,
                          .period_us = 1000,
                          .method    = set_ups[set_up].method,
                          .guarded   = set_ups[set_up].guarded,
                          .factor    = 0.8 + 0.4 * uniform(&random),
                          .noise_n   = NOISE_N,
                          .seed      = n};
    const double size  = row->low_n + (row->high_n - row->low_n) * uniform(&random);
    const double level = uniform(&random) < 0.5 ? size : -size;
    const bool   moves = uniform(&random) < 0.5;
    const double at_s  = 2.0 + 10.0 * uniform(&random);
    open_rig(&rig, &kind);
    while ((double)rig.tick * rig.h_s < at_s)
    {
        if (!advance_at(&rig, level, moves))
        {
            fail("a healthy drive has stopped");
        }
    }
    const uint64_t at = rig.tick;
    break_rig(&rig, row->what);
    bool on = true;
    while (on && (double)(rig.tick - at) * rig.h_s < BROKEN_S)
    {
        on = advance_at(&rig, level, moves);
    }
    found->worst_ms = fmax(found->worst_ms, (double)(rig.tick - at) * rig.h_s * 1e3);
    found->never += on;
}

/// Misses of a target, counting cells; all rows, or those with a target.
static unsigned study_broken(unsigned rigs, bool targets_only)
{
    unsigned missed = 0;
    printf("| %s, r in N |", TRIBO_ARITHMETIC);
    for (unsigned m = 0; m < SET_UPS; m++)
    {
        printf(" %s |", set_ups[m].name);
    }
    printf(" target |\n|---|---|---|---|---|---|---|\n");
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
    {
        const row_t *const row = &rows[i];
        if (targets_only && row->target_ms == 0.0)
        {
            continue;
        }
        printf("| %s, %g to %g |", break_names[row->what], row->low_n, row->high_n);
        for (unsigned m = 0; m < SET_UPS; m++)
        {
            found_t found = {0};
            for (unsigned n = 0; n < rigs; n++)
            {
                play_broken(&found, row, m, n);
            }
            if (found.never > 0u)
            {
                printf(" never: %u of %u |", found.never, rigs);
            }
            else
            {
                printf(" %.0f |", found.worst_ms);
            }
            missed += row->target_ms > 0.0 && found.worst_ms > row->target_ms;
            (void)fflush(stdout);
        }
        printf(" %g |\n", row->target_ms);
    }
    return missed;
}

// --- loose ---------------------------------------------------------------------------------------------------------

#define LOOSE_MS 200.0
#define LAST_S   5.0

typedef struct
{
    unsigned cells, missed;
    double   worst_ms;
} seen_t;

static void note(seen_t *seen, double ms, double most_ms)
{
    seen->cells++;
    seen->missed += ms > most_ms;
    seen->worst_ms = fmax(seen->worst_ms, ms);
}

/// 0 N for `off_ms` of `of_ms`: how long the drive runs on.
static double loose_ms(rig_t *rig, const kind_t *kind, double reference, double off_ms, double of_ms)
{
    open_rig(rig, kind);
    rig->reference = reference;
    if (!advance_for(rig, 2.0))
    {
        print_kind(rig);
        printf("%s at rest at %.2f\n", drive_fault_text(rig->drive.fault), reference);
        return 0.0;
    }
    const uint64_t at = rig->tick;
    while ((double)(rig->tick - at) * rig->h_s < LAST_S)
    {
        const bool off = fmod((double)(rig->tick - at) * rig->h_s * 1e3, of_ms) < off_ms - 1e-6;
        rig->broken    = off ? DETACHED : HEALTHY;
        if (!advance(rig))
        {
            break;
        }
    }
    return (double)(rig->tick - at) * rig->h_s * 1e3;
}

static unsigned study_loose(unsigned rigs, uint64_t seed)
{
    static const struct
    {
        double off_ms, of_ms;
    } patterns[]                 = {{30.0, 40.0}, {49.0, 50.0}, {30.0, 60.0}};
    static const double levels[] = {0.15, -0.15, 0.3, 0.5, -0.8, 1.0};
    static rig_t        rig;
    unsigned            missed = 0;
    for (size_t p = 0; p < sizeof patterns / sizeof patterns[0]; p++)
    {
        seen_t seen = {0};
        for (unsigned n = 0; n < rigs; n++)
        {
            const kind_t kind = kind_of(n, seed);
            for (size_t i = 0; i < sizeof levels / sizeof levels[0]; i++)
            {
                const double ms = loose_ms(&rig, &kind, levels[i], patterns[p].off_ms, patterns[p].of_ms);
                note(&seen, ms, LOOSE_MS);
                if (ms > LOOSE_MS)
                {
                    print_kind(&rig);
                    printf("r %.2f N: %.0f ms\n", levels[i], ms);
                }
            }
        }
        printf("%s: 0 N for %g of %g ms: %u cells, worst %.0f ms, %u beyond %g ms\n",
               TRIBO_ARITHMETIC,
               patterns[p].off_ms,
               patterns[p].of_ms,
               seen.cells,
               seen.worst_ms,
               seen.missed,
               LOOSE_MS);
        missed += seen.missed;
    }
    return missed;
}

// --- restart -------------------------------------------------------------------------------------------------------

#define RESTART_MS 500.0

/// Stopped and started every 50 ms.
static double restart_ms(rig_t *rig, const kind_t *kind, double reference, break_t what)
{
    open_rig(rig, kind);
    rig->reference = reference;
    (void)advance_for(rig, 1.0);
    break_rig(rig, what);
    const uint64_t at   = rig->tick;
    const uint64_t each = (uint64_t)(0.05 / rig->h_s + 0.5);
    while (rig->drive.state != DRIVE_FAULT && (double)(rig->tick - at) * rig->h_s < LAST_S)
    {
        if ((rig->tick - at) % each == 0u)
        {
            drive_stop(&rig->drive);
        }
        if ((rig->tick - at) % each == 1u)
        {
            drive_start(&rig->drive);
        }
        (void)advance(rig);
    }
    return (double)(rig->tick - at) * rig->h_s * 1e3;
}

/// Nothing is broken: false stops of rigs that are stopped and started five times in 50 ms to 1 s, and again 1.5 s later.
static unsigned study_healthy_restarts(unsigned rigs, uint64_t seed)
{
    static const double each_s[] = {0.01, 0.02, 0.05, 0.1, 0.2};
    static rig_t        rig;
    unsigned            stops = 0;
    for (unsigned n = 0; n < rigs; n++)
    {
        const kind_t kind = kind_of(n, seed);
        open_rig(&rig, &kind);
        rig.reference = -0.9 + 1.8 * uniform(&rig.random);
        bool on       = advance_for(&rig, 1.0);
        for (unsigned i = 0; on && i < 15u; i++)
        {
            drive_stop(&rig.drive);
            on = advance(&rig);
            drive_start(&rig.drive);
            on = on && advance_for(&rig, each_s[n % 5u] + (i % 5u == 4u ? 1.5 : 0.0));
        }
        if (!on)
        {
            print_kind(&rig);
            printf("%s after restarts every %g s at %.2f N\n",
                   drive_fault_text(rig.drive.fault),
                   each_s[n % 5u],
                   rig.reference);
        }
        stops += !on;
    }
    printf("%s: %u healthy rigs restarted: %u false stops\n", TRIBO_ARITHMETIC, rigs, stops);
    return stops;
}

static unsigned study_restart(unsigned rigs, uint64_t seed)
{
    static const break_t breaks[] = {DETACHED, CONTACT_LOST};
    static const double  levels[] = {0.3, -0.5, 0.8};
    static rig_t         rig;
    unsigned             missed = 0;
    for (unsigned what = 0; what < 2u; what++)
    {
        seen_t seen = {0};
        for (unsigned n = 0; n < rigs; n++)
        {
            const kind_t kind = kind_of(n, seed);
            for (size_t i = 0; i < sizeof levels / sizeof levels[0]; i++)
            {
                const double ms = restart_ms(&rig, &kind, levels[i], breaks[what]);
                note(&seen, ms, RESTART_MS);
                if (ms > RESTART_MS)
                {
                    print_kind(&rig);
                    printf("r %.2f N: %.0f ms\n", levels[i], ms);
                }
            }
        }
        printf("%s: started every 50 ms, %s: %u cells, worst %.0f ms, %u beyond %g ms\n",
               TRIBO_ARITHMETIC,
               break_names[breaks[what]],
               seen.cells,
               seen.worst_ms,
               seen.missed,
               RESTART_MS);
        missed += seen.missed;
    }
    return missed;
}

// --- swing ---------------------------------------------------------------------------------------------------------

#define SWING_S 1.0

static void put_sections(params_set_t *set, uint32_t count)
{
    memcpy((char *)set + 4u * (uint32_t)PARAMS_SECTION_COUNT, &count, sizeof count);
}

static void tune_gain(params_set_t *set, double gain)
{
    set->sections[0].b0 *= (float)gain;
    set->sections[0].b1 *= (float)gain;
    set->sections[0].b2 *= (float)gain;
}

/// Hardly damped: the loop cannot hold it.
static void tune_resonance(params_set_t *set, double hz, double h_s)
{
    const double w = 6.283185307 * hz * h_s;
    put_pi(set, 0.5, 10.0, h_s);
    set->sections[1] = (tribo_biquad_f32_section_t){1.0f,
                                                    (float)(2.0 * w),
                                                    (float)(30.0 * w * w),
                                                    (float)(0.02 * w + w * w),
                                                    (float)(w * w)};
    put_sections(set, 2);
}

/// A double pole, so that the loop swings slowly.
static void tune_lag(params_set_t *set, double hz, double h_s)
{
    const double w = 1.0 - exp(-6.283185307 * hz * h_s);
    put_pi(set, 8.0, 40.0, h_s);
    set->sections[1] = (tribo_biquad_f32_section_t){1e-5f, 0.0f, (float)(w * w), (float)(2.0 * w), (float)(w * w)};
    put_sections(set, 2);
}

/// PI with anything behind it, and any compensation.
static void tune_at_random(params_set_t *set, double kp, double ki, double h_s, sim_random_t *random)
{
    put_pi(set, kp, ki, h_s);
    if (uniform(random) < 0.5)
    {
        const double b0 = 1.0 + 30.0 * uniform(random) * uniform(random);
        const double b1 = 2.0 * uniform(random);
        const double b2 = uniform(random);
        const double a1 = 0.3 + uniform(random);
        set->sections[1] =
            (tribo_biquad_f32_section_t){(float)b0, (float)b1, (float)b2, (float)a1, (float)(0.3 * uniform(random))};
        put_sections(set, 2);
    }
    put(set, PARAMS_GAIN, 2.0 * uniform(random));
    put(set, PARAMS_BREAKAWAY_SLOPE, 2.0 * uniform(random));
}

/// A client's tuning: the n-th.
static const char *tune(params_set_t *set, unsigned n, double h_s, sim_random_t *random)
{
    static const double gains[]     = {3.0, 5.0, 8.0, 10.0, 15.0, 30.0, 100.0, 1000.0};
    static const double integrals[] = {60.0, 100.0, 150.0, 200.0, 400.0, 1000.0, 4000.0, 1e5};
    static const double kps[]       = {1.5, 3.0, 5.0, 8.0, 12.0, 20.0, 50.0, 500.0};
    static const double hz[]        = {0.3, 0.7, 1.5, 3.0, 6.0, 12.0, 25.0, 60.0};
    static const double lags_hz[]   = {0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.5, 3.0};
    static char         name[96];
    const double        kp = exp(log(0.01) + uniform(random) * log(1e4));
    const double        ki = exp(log(1.0) + uniform(random) * log(1e4));
    switch (n / 8u)
    {
    case 0:
        tune_gain(set, gains[n]);
        (void)snprintf(name, sizeof name, "gain x %g", gains[n]);
        break;
    case 1:
        put_pi(set, 0.0, integrals[n - 8u], h_s);
        (void)snprintf(name, sizeof name, "integral of %g/s", integrals[n - 8u]);
        break;
    case 2:
        put_pi(set, kps[n - 16u], kps[n - 16u] * 20.0, h_s);
        (void)snprintf(name, sizeof name, "PI of %g", kps[n - 16u]);
        break;
    case 3:
        tune_resonance(set, hz[n - 24u], h_s);
        (void)snprintf(name, sizeof name, "resonance at %g Hz", hz[n - 24u]);
        break;
    case 8:
        tune_lag(set, lags_hz[n - 64u], h_s);
        (void)snprintf(name, sizeof name, "lag of %g Hz", lags_hz[n - 64u]);
        break;
    default:
        tune_at_random(set, kp, ki, h_s, random);
        (void)snprintf(name, sizeof name, "kp %.3g, ki %.3g/s and more", kp, ki);
    }
    return name;
}

/// Turns of u by a quarter of its range, and of y by 0.3 N of the paper's 4 N.
typedef struct
{
    double turn;
    bool   falls;
} wave_t;

/// True at a turn.
static bool watch(wave_t *wave, double x, double least)
{
    if (wave->falls ? x < wave->turn : x > wave->turn)
    {
        wave->turn = x;
    }
    if (fabs(x - wave->turn) <= least)
    {
        return false;
    }
    wave->falls = !wave->falls;
    wave->turn  = x;
    return true;
}

#define SWING_END_S   40.0 // while it grows
#define SWING_REST_S  0.4  // without a turn: it is another swing
#define NEAR_LIMIT    1.9  // of u; the limit is at 2 N
#define LIMITS_REST_S 5.0  // without u there: likewise

/// The turns of one swing.
typedef struct
{
    double onset_s, last_s; // -1: none yet
} turns_t;

static void note_turn(turns_t *turns, double at_s, double rest_s)
{
    if (turns->onset_s < 0.0 || at_s - turns->last_s > rest_s)
    {
        turns->onset_s = at_s;
    }
    turns->last_s = at_s;
}

typedef struct
{
    wave_t  of_u, of_y;
    turns_t any, limits; // of u or y; of u near a limit
    double  end_s;
    bool    on;
} swing_t;

/// Does it swing in the end, or until the stop?
static bool is_still(const swing_t *swing, const turns_t *turns, double rest_s)
{
    return turns->onset_s >= 0.0 && (!swing->on || swing->end_s - turns->last_s < rest_s);
}

/// From now on, for SWING_END_S or until the drive stops. `moves`: r is the triangle of the benchmark.
static swing_t watch_swings(rig_t *rig, bool moves)
{
    swing_t        swing = {.any = {-1.0, -1.0}, .limits = {-1.0, -1.0}, .on = true};
    const uint64_t at    = rig->tick;
    while (swing.on && swing.end_s < SWING_END_S)
    {
        const double phase = fmod(swing.end_s, 20.0) / 10.0;
        rig->reference     = moves ? 0.4 + 0.2 * phase : rig->reference;
        swing.on           = advance(rig);
        swing.end_s        = (double)(rig->tick - at) * rig->h_s;
        const double u     = of_paper(rig, rig->board.command);
        const bool   of_u  = swing.on && watch(&swing.of_u, u, 1.0);
        const bool   of_y  = swing.on && watch(&swing.of_y, rig->plant.filtered_n, 0.3);
        if (swing.on && fabs(u) > NEAR_LIMIT)
        {
            note_turn(&swing.limits, swing.end_s, LIMITS_REST_S);
        }
        if (of_u || of_y)
        {
            note_turn(&swing.any, swing.end_s, SWING_REST_S);
        }
    }
    return swing;
}

typedef struct
{
    seen_t   seen, limits;
    unsigned run_on;
} swings_t;

static void play_tuning(swings_t *all, unsigned n, unsigned t)
{
    static rig_t rig;
    const kind_t kind = kind_of(n, 1u + t);
    sim_random_t random;
    sim_random_seed(&random, 1000u * n + t);
    open_rig(&rig, &kind);
    rig.reference = t % 3u == 0u ? 0.0 : t % 3u == 1u ? 0.3 : -0.6;
    if (!advance_for(&rig, 1.5))
    {
        fail("a healthy drive has stopped");
    }
    params_set_t      set  = rig.params[rig.used].set;
    const char *const name = tune(&set, t, rig.h_s, &random);
    if (!apply(&rig, &set))
    {
        return;
    }
    drive_change(&rig.drive, &rig.params[rig.used].drive);
    const swing_t swing     = watch_swings(&rig, t % 4u == 3u);
    const bool    of_any    = is_still(&swing, &swing.any, SWING_REST_S);
    const bool    of_limits = is_still(&swing, &swing.limits, LIMITS_REST_S);
    const double  any_s     = of_any ? swing.end_s - swing.any.onset_s : 0.0;
    const double  limits_s  = of_limits ? swing.end_s - swing.limits.onset_s : 0.0;
    if (of_limits)
    {
        note(&all->limits, 1e3 * limits_s, 1e3 * SWING_S);
    }
    if (of_any)
    {
        note(&all->seen, 1e3 * any_s, 1e3 * SWING_S);
        all->run_on += swing.on;
    }
    if (any_s > SWING_S || limits_s > SWING_S || (of_any && swing.on))
    {
        const char *const end = swing.on ? "runs on" : drive_fault_text(rig.drive.fault);
        print_kind(&rig);
        printf("%s: %s after %.2f s, at limits %.2f s\n", name, end, any_s, limits_s);
    }
}

#define TUNINGS    72u
#define SLOW_SHARE 0.05 // of loops that swing: small, or while they grow

/// True if a loop swings on for longer than SWING_S once u has been near a limit, or too many of all do.
static bool study_swing(unsigned rigs, unsigned step)
{
    static swings_t all;
    for (unsigned n = 0; n < rigs; n++)
    {
        for (unsigned t = n % step; t < TUNINGS; t += step)
        {
            play_tuning(&all, n, t);
        }
    }
    printf("%s: %u loops that swing, worst %.0f ms, %u beyond %g ms, %u run on\n",
           TRIBO_ARITHMETIC,
           all.seen.cells,
           all.seen.worst_ms,
           all.seen.missed,
           SWING_S * 1e3,
           all.run_on);
    printf("    once u has been near a limit: %u, worst %.0f ms, %u beyond\n",
           all.limits.cells,
           all.limits.worst_ms,
           all.limits.missed);
    return all.limits.missed > 0u || all.seen.missed > SLOW_SHARE * all.seen.cells;
}

// --- healthy -------------------------------------------------------------------------------------------------------

typedef enum
{
    STEPS,
    WIDE_STEPS,
    FAST_SQUARE,
    FAST_SMALL_SQUARE,
    TRIANGLE,
    SINE,
    HOLD,
    PUSHES,
    SHAPES
} shape_t;

static const char *const shape_names[] =
    {"steps", "wide steps", "fast square", "small fast square", "triangle", "sine", "hold", "pushes"};

typedef struct
{
    shape_t shape;
    double  low, high, period_s, push;
} part_t;

static part_t part_of(sim_random_t *random)
{
    part_t part   = {.shape = (shape_t)(uniform(random) * (double)SHAPES)};
    part.low      = -0.9 + 1.2 * uniform(random);
    part.high     = fmin(part.low + 0.2 + 0.4 * uniform(random), 0.9);
    part.period_s = 1.0 + 9.0 * uniform(random);
    if (part.shape == WIDE_STEPS)
    {
        part.low  = -0.8;
        part.high = 0.8;
    }
    if (part.shape == FAST_SQUARE || part.shape == FAST_SMALL_SQUARE)
    {
        part.period_s = 0.05 + 0.45 * uniform(random);
        part.high     = part.shape == FAST_SQUARE ? part.high : part.low + 0.15;
    }
    if (part.shape == SINE)
    {
        part.period_s = 0.2 + 5.0 * uniform(random);
    }
    if (part.shape == HOLD || part.shape == PUSHES)
    {
        part.high = part.low;
        part.push = part.shape == PUSHES ? 0.1 : 0.0;
    }
    return part;
}

static double shape_at(const part_t *part, double t_s)
{
    const double phase = fmod(t_s, part->period_s) / part->period_s;
    const bool   steps = part->shape <= FAST_SMALL_SQUARE;
    const double rise  = steps                 ? (phase < 0.5 ? 0.0 : 1.0)
                         : part->shape == SINE ? 0.5 - 0.5 * cos(6.283185307179586 * phase)
                                               : (phase < 0.5 ? 2.0 * phase : 2.0 - 2.0 * phase);
    return part->low + (part->high - part->low) * rise;
}

typedef struct
{
    double   hours;
    unsigned stops;
} healthy_t;

typedef struct
{
    double at_s, for_s, size;
} push_t;

/// Half a sine, again and again.
static double push_n(push_t *push, const part_t *part, double t_s, sim_random_t *random)
{
    if (t_s > push->at_s + push->for_s)
    {
        push->at_s  = t_s + 0.5 * uniform(random);
        push->for_s = 0.02 + 0.3 * uniform(random);
        push->size  = part->push * (2.0 * uniform(random) - 1.0);
    }
    return t_s > push->at_s ? push->size * sin(3.14159265 * (t_s - push->at_s) / push->for_s) : 0.0;
}

#define PART_S 10.0

static bool play_part(rig_t *rig, const part_t *part, sim_random_t *random)
{
    const uint64_t at   = rig->tick;
    push_t         push = {.for_s = 0.1};
    bool           on   = true;
    for (double t_s = 0.0; on && t_s < PART_S; t_s = (double)(rig->tick - at) * rig->h_s)
    {
        rig->reference    = shape_at(part, t_s);
        rig->plant.hand_n = push_n(&push, part, t_s, random);
        on                = advance(rig);
    }
    return on;
}

static void play_healthy(healthy_t *seen, const kind_t *kind, double time_s)
{
    static rig_t rig;
    sim_random_t random;
    sim_random_seed(&random, kind->seed);
    open_rig(&rig, kind);
    bool on = true;
    while (on && (double)rig.tick * rig.h_s < time_s)
    {
        const part_t part = part_of(&random);
        on                = play_part(&rig, &part, &random);
        if (!on)
        {
            print_kind(&rig);
            printf("%s in %s %.2f to %.2f in %.2f s\n",
                   drive_fault_text(rig.drive.fault),
                   shape_names[part.shape],
                   part.low,
                   part.high,
                   part.period_s);
        }
    }
    seen->hours += (double)rig.tick * rig.h_s / 3600.0;
    seen->stops += !on;
}

static unsigned study_healthy(double hours, uint64_t seed)
{
    static healthy_t seen;
    for (unsigned n = 0; n < RIGS; n++)
    {
        const kind_t kind = kind_of(n, seed);
        play_healthy(&seen, &kind, 3600.0 * hours / RIGS);
        (void)fflush(stdout);
    }
    printf("%s: %u rigs, %.2f hours: %u false stops\n", TRIBO_ARITHMETIC, RIGS, seen.hours, seen.stops);
    return seen.stops;
}

// --- the program ---------------------------------------------------------------------------------------------------

#define CHECK_RIGS  6u
#define CHECK_HOURS 0.1

static int check(void)
{
    const unsigned missed = study_broken(CHECK_RIGS, true) + study_loose(CHECK_RIGS, 1) + study_restart(CHECK_RIGS, 1);
    const bool     slow   = study_swing(CHECK_RIGS, 4);
    const unsigned stops  = study_healthy(CHECK_HOURS, 1) + study_healthy_restarts(CHECK_RIGS, 1);
    printf("%u targets missed, swings are stopped %s, %u false stops\n", missed, slow ? "late" : "in time", stops);
    return missed > 0u || slow || stops > 0u;
}

int main(int count, char **arguments)
{
    const char *const what   = count > 1 ? arguments[1] : "";
    const double      amount = count > 2 ? strtod(arguments[2], NULL) : 0.0;
    const unsigned    rigs   = amount >= 1.0 && amount <= 1000.0 ? (unsigned)amount : 0u;
    if (strcmp(what, "check") == 0)
    {
        return check();
    }
    if (strcmp(what, "broken") == 0 && rigs > 0u)
    {
        return study_broken(rigs, false) > 0u;
    }
    if (strcmp(what, "swing") == 0 && rigs > 0u)
    {
        return study_swing(rigs, 1);
    }
    if (strcmp(what, "healthy") == 0 && amount > 0.0)
    {
        return study_healthy(amount, 1) > 0u;
    }
    (void)fputs("usage: loop_study_f32|q31 broken RIGS | swing RIGS | healthy HOURS | check\n", stderr);
    return 2;
}
