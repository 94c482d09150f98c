#include "rig.h"

#include "scenario/keys.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void write_value(rig_t *rig, const common_key_t *key, double value)
{
    void *at = (char *)rig->own + key->offset;
    switch (key->type)
    {
    case COMMON_KEY_WHOLE:
        memcpy(at, &(uint64_t){(uint64_t)value}, sizeof(uint64_t));
        break;
    case COMMON_KEY_CHOICE:
        memcpy(at, &(int){(int)value}, sizeof(int));
        break;
    default:
        TEST_ASSERT_EQUAL_INT(COMMON_KEY_NUMBER, key->type);
        memcpy(at, &value, sizeof value);
        break;
    }
}

void rig_init(rig_t *rig, const sim_truth_ops_t *truth)
{
    rig->truth       = truth;
    rig->config      = (sim_truth_config_t){.friction = {.k_min         = 6.0,
                                                         .k_max         = 20.0,
                                                         .m             = 3.0,
                                                         .v0_n_per_s    = 0.007,
                                                         .breakaway     = {.offset_n = 0.007, .slope = 0.3},
                                                         .set_level     = 0.75,
                                                         .reset_level   = 0.8,
                                                         .pulse_width_s = 0.003},
                                            .arm      = {.inertia = 1.2e-4, .damping = 0.0288, .stiffness = 3.84}};
    rig->drive_error = (sim_drive_error_t){0};
    rig->config.own  = rig->own;
    memset(rig->own, 0, sizeof rig->own);
    for (const common_key_t *key = truth->keys; key != NULL && key->name != NULL; key++)
    {
        write_value(rig, key, key->standard);
    }
}

bool rig_has(const rig_t *rig, const char *name)
{
    return common_key_in(rig->truth->keys, name, strlen(name)) != NULL;
}

void rig_set(rig_t *rig, const char *name, double value)
{
    const common_key_t *key = common_key_in(rig->truth->keys, name, strlen(name));
    TEST_ASSERT_NOT_NULL_MESSAGE(key, name);
    TEST_ASSERT_TRUE_MESSAGE(key->type == COMMON_KEY_CHOICE || (value >= key->min && value <= key->max), name);
    write_value(rig, key, value);
}

void rig_constant_breakaway(rig_t *rig, double level_n)
{
    rig->config.friction.breakaway.offset_n = level_n;
    rig->config.friction.breakaway.slope    = 0.0;
}

void rig_run(const rig_t *rig, double step_s, const rig_ramp_t *ramps, unsigned count, rig_see_t see, void *context)
{
    void *model = rig->truth->create(&rig->config, step_s);
    TEST_ASSERT_NOT_NULL(model);
    sim_truth_signals_t signals = {0};
    double              from    = 0.0;
    long                done    = 0;
    double              past    = 0.0;
    double              before  = 0.0;
    for (unsigned i = 0; i < count; i++)
    {
        const long steps = lround(ramps[i].seconds / step_s);
        for (long k = 0; k < steps; k++)
        {
            // Held at its mean over the step: the ramp to second order.
            const double u      = from + (ramps[i].to_n - from) * ((double)k + 0.5) / (double)steps;
            const double middle = (1.5 * past - 0.5 * before) / rig->config.arm.stiffness;
            const double felt   = sim_drive_error_command(&rig->drive_error, u) +
                                sim_drive_error_ripple(&rig->drive_error, middle).force_n;
            const double force = rig->truth->step(model, felt, &signals);
            done++;
            const rig_sample_t sample = {.time_s          = (double)done * step_s,
                                         .u_n             = u,
                                         .force_n         = force,
                                         .f_n             = signals.f_n,
                                         .speed_deg_per_s = (force - past) / step_s / rig->config.arm.stiffness};
            before                    = past;
            past                      = force;
            see(context, &sample);
        }
        from = ramps[i].to_n;
    }
    rig->truth->destroy(model);
}

typedef struct
{
    const rig_ramp_t *ramps;
    double           *forces_n;
    unsigned          index;
    double            end_s;
} ends_t;

static void take_end(void *context, const rig_sample_t *sample)
{
    ends_t *ends                = context;
    ends->forces_n[ends->index] = sample->force_n;
    if (sample->time_s > ends->end_s - 0.5 * RIG_STEP_S)
    {
        ends->index++;
        ends->end_s += ends->ramps[ends->index].seconds;
    }
}

#define RAMPS_MAX 128

void rig_forces(const rig_t *rig, const rig_ramp_t *ramps, unsigned count, double forces_n[])
{
    rig_ramp_t copy[RAMPS_MAX + 1] = {{0}}; // zero-terminated
    double     forces[RAMPS_MAX + 1];
    TEST_ASSERT_LESS_OR_EQUAL_UINT(RAMPS_MAX, count);
    memcpy(copy, ramps, count * sizeof *ramps);
    ends_t ends = {copy, forces, 0, copy[0].seconds};
    rig_run(rig, RIG_STEP_S, copy, count, take_end, &ends);
    TEST_ASSERT_EQUAL_UINT(count, ends.index);
    memcpy(forces_n, forces, count * sizeof *forces);
}

#define SWINGS 50

double rig_lift(const rig_t *rig, double bottom_n, double seconds)
{
    rig_ramp_t ramps[] = {{0.6, 3.0}, {bottom_n, 2.4}, {bottom_n, 0.1}, {0.0, 0.0}};
    double     forces[4];
    rig_forces(rig, ramps, 3, forces);
    const double bottom = forces[2];
    ramps[3]            = (rig_ramp_t){bottom + 0.9 * (0.007 + 0.3 * bottom), seconds};
    rig_forces(rig, ramps, 4, forces);
    printf("from %.4f N in %g s: %.2e N\n", bottom, seconds, forces[3] - bottom);
    return forces[3] - bottom;
}

double rig_drift(const rig_t *rig, double swing_s)
{
    rig_ramp_t ramps[3 + (2 * SWINGS)] = {{0.5, 2.0}, {0.5, 0.2}};
    double     forces[3 + (2 * SWINGS)];
    rig_forces(rig, ramps, 2, forces);
    const double force     = forces[1];
    const double breakaway = sim_breakaway_at(&rig->config.friction.breakaway, force).positive_n;
    ramps[2]               = (rig_ramp_t){force, 0.5};
    for (unsigned i = 0; i < SWINGS; i++)
    {
        ramps[3 + (2 * i)] = (rig_ramp_t){force + 0.8 * breakaway, 0.5 * swing_s};
        ramps[4 + (2 * i)] = (rig_ramp_t){force + 0.2 * breakaway, 0.5 * swing_s};
    }
    rig_forces(rig, ramps, 3 + (2 * SWINGS), forces);
    return forces[2 + (2 * SWINGS)] - forces[4];
}

typedef struct
{
    double start_s, from_n, rate_n_per_s;
} line_t;

static cvode_drive_t on_line(const void *context, double time_s)
{
    const line_t *line = context;
    return (cvode_drive_t){.u_n          = line->from_n + line->rate_n_per_s * (time_s - line->start_s),
                           .rate_n_per_s = line->rate_n_per_s};
}

void rig_run_reference(const rig_t           *rig,
                       const cvode_options_t *options,
                       double                 every_s,
                       const rig_ramp_t      *ramps,
                       unsigned               count,
                       rig_see_t              see,
                       void                  *context,
                       cvode_cost_t          *cost)
{
    cvode_t *reference = cvode_create(rig->truth, &rig->config, options);
    TEST_ASSERT_NOT_NULL(reference);
    cvode_set_drive_error(reference, &rig->drive_error);
    line_t line = {0};
    long   done = 0;
    for (unsigned i = 0; i < count; i++)
    {
        line.rate_n_per_s = (ramps[i].to_n - line.from_n) / ramps[i].seconds;
        TEST_ASSERT_TRUE(cvode_drive(reference, on_line, &line, line.start_s + ramps[i].seconds));
        const long samples = lround(ramps[i].seconds / every_s);
        for (long k = 1; k <= samples; k++)
        {
            const double until = line.start_s + ramps[i].seconds * (double)k / (double)samples;
            TEST_ASSERT_TRUE_MESSAGE(cvode_advance(reference, until), cvode_problem(reference));
            done++;
            const rig_sample_t sample = {.time_s          = (double)done * every_s,
                                         .u_n             = on_line(&line, until).u_n,
                                         .force_n         = cvode_force(reference),
                                         .f_n             = cvode_friction(reference),
                                         .speed_deg_per_s = cvode_speed(reference)};
            see(context, &sample);
        }
        line.start_s += ramps[i].seconds;
        line.from_n = ramps[i].to_n;
    }
    if (cost != NULL)
    {
        *cost = cvode_cost(reference);
    }
    cvode_destroy(reference);
}

const rig_ramp_t rig_compare_ramps[] =
    {{0.6, 3.0}, {0.1, 2.0}, {0.55, 2.0}, {0.45, 1.0}, {0.52, 1.0}, {0.44, 1.0}, {-0.4, 3.0}, {0.2, 0.5}, {0.0, 0.5}};
const unsigned rig_compare_count = sizeof rig_compare_ramps / sizeof rig_compare_ramps[0];

#define SAMPLE_S 1e-3

typedef struct
{
    double *force_n; ///< at every SAMPLE_S
    long    count, size;
} record_t;

static void record_if_due(void *context, const rig_sample_t *sample)
{
    record_t    *record = context;
    const double due    = (double)(record->count + 1) * SAMPLE_S;
    if (record->count < record->size && sample->time_s > due - 1e-9)
    {
        record->force_n[record->count++] = sample->force_n;
    }
}

rig_comparison_t rig_compare(const rig_t      *rig,
                             double            step_s,
                             const rig_ramp_t *ramps,
                             unsigned          count,
                             cvode_cost_t     *cost)
{
    double seconds = 0.0;
    for (unsigned i = 0; i < count; i++)
    {
        seconds += ramps[i].seconds;
    }
    const long size  = lround(seconds / SAMPLE_S);
    record_t   fixed = {calloc((size_t)size, sizeof(double)), 0, size};
    record_t   exact = {calloc((size_t)size, sizeof(double)), 0, size};
    TEST_ASSERT_NOT_NULL(fixed.force_n);
    TEST_ASSERT_NOT_NULL(exact.force_n);
    rig_run(rig, step_s, ramps, count, record_if_due, &fixed);
    rig_run_reference(rig, &cvode_defaults, SAMPLE_S, ramps, count, record_if_due, &exact, cost);
    TEST_ASSERT_EQUAL_INT64(size, fixed.count);
    TEST_ASSERT_EQUAL_INT64(size, exact.count);

    rig_comparison_t comparison = {0};
    for (long i = 0; i < size; i++)
    {
        const double difference = fabs(fixed.force_n[i] - exact.force_n[i]);
        comparison.largest_n    = fmax(comparison.largest_n, fabs(exact.force_n[i]));
        if (!(difference <= comparison.difference))
        {
            comparison.difference = difference;
            comparison.at_s       = (double)(i + 1) * SAMPLE_S;
        }
    }
    comparison.difference /= comparison.largest_n;
    free(fixed.force_n);
    free(exact.force_n);
    return comparison;
}

void rig_slide_start(rig_slide_t *slide, const rig_t *rig, double force_n)
{
    memset(slide, 0, sizeof *slide);
    slide->law      = rig->truth->law;
    slide->friction = calloc(1, slide->law->size);
    TEST_ASSERT_NOT_NULL(slide->friction);
    sim_law_reset(slide->law, slide->friction, &rig->config, slide->z);
    slide->contact.force_n   = force_n;
    slide->contact.breakaway = sim_breakaway_at(&rig->config.friction.breakaway, force_n);
}

void rig_slide_end(rig_slide_t *slide)
{
    free(slide->friction);
    slide->friction = NULL;
}

double rig_slide_step(rig_slide_t *slide, double speed_deg_per_s, double step_s)
{
    double               z_end[SIM_LAW_STATES_MAX] = {0};
    const sim_law_step_t step                      = {.start = slide->contact, .z = slide->z, .length_s = step_s};
    slide->f_n                                     = slide->law->update(slide->friction, &step, speed_deg_per_s, z_end);
    memcpy(slide->z, z_end, sizeof slide->z);
    slide->position_deg += speed_deg_per_s * step_s;
    slide->contact.time_s += step_s;
    slide->contact.speed_deg_per_s = speed_deg_per_s;
    if (slide->law->settle != NULL)
    {
        slide->law->settle(slide->friction, &slide->contact, slide->z);
    }
    return slide->f_n;
}

double rig_slide_by(rig_slide_t *slide, double distance_deg, double speed_deg_per_s, double step_s)
{
    const double seconds = fabs(distance_deg) / speed_deg_per_s;
    const long   steps   = (long)ceil(seconds / step_s - 1e-9);
    for (long i = 0; i < steps; i++)
    {
        (void)rig_slide_step(slide, copysign(speed_deg_per_s, distance_deg), seconds / (double)steps);
    }
    return slide->f_n;
}

double rig_part_after(const rig_t *rig, double way_deg, double force_n)
{
    rig_slide_t slide;
    rig_slide_start(&slide, rig, force_n);
    const double part = rig_slide_by(&slide, way_deg, 0.001, 1e-4) / (0.007 + 0.3 * force_n);
    rig_slide_end(&slide);
    return part;
}

double rig_inner_loop(const rig_t *rig)
{
    rig_slide_t slide;
    rig_slide_start(&slide, rig, 0.5);
    (void)rig_slide_by(&slide, 8e-4, 1e-4, 1e-4);
    (void)rig_slide_by(&slide, -8e-4, 1e-4, 1e-4);
    const double plain = rig_slide_by(&slide, 6e-4, 1e-4, 1e-4);
    rig_slide_end(&slide);

    rig_slide_start(&slide, rig, 0.5);
    (void)rig_slide_by(&slide, 8e-4, 1e-4, 1e-4);
    (void)rig_slide_by(&slide, -8e-4, 1e-4, 1e-4);
    const double corner = rig_slide_by(&slide, 4e-4, 1e-4, 1e-4);
    (void)rig_slide_by(&slide, -2e-4, 1e-4, 1e-4);
    const double closed = rig_slide_by(&slide, 2e-4, 1e-4, 1e-4);
    const double beyond = rig_slide_by(&slide, 2e-4, 1e-4, 1e-4);
    rig_slide_end(&slide);
    printf("%s: corner %.5f, closed %.5f; plain %.5f, with inner loop %.5f N\n",
           rig->truth->name,
           corner,
           closed,
           plain,
           beyond);
    return fmax(fabs(closed - corner), fabs(beyond - plain));
}
