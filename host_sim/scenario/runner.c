#include "scenario/runner.h"

#include "scenario/check.h"
#include "scenario/loop_config.h"
#include "scenario/reference.h"
#include "support/clock.h"
#include "target/target.h"

#include <math.h>

/// All that lives while a scenario runs.
typedef struct
{
    const sim_config_t *config;
    sim_run_options_t   options;
    sim_reference_t     reference;
    sim_plant_config_t  plant_config;
    sim_plant_t        *plant;
    sim_sensor_t        sensor;

    sim_loop_config_t loop_config;
    sim_loop_t        loop;
    sim_target_t     *target; ///< null: the loop runs here

    uint64_t ticks;
    unsigned steps; ///< of the plant, a tick
} run_t;

typedef struct
{
    double   error_squares, measured_squares, max_error_n;
    uint64_t count;
} metrics_t;

/// Of Q31 and f32.
typedef struct
{
    double u_squares, force_squares, max_u_n, max_force_n;
} difference_t;

static void tear_down(run_t *run)
{
    sim_reference_free(&run->reference);
    sim_plant_destroy(run->plant);
    sim_sensor_free(&run->sensor);
    sim_target_destroy(run->target);
}

static bool set_up_plant(run_t *run, sim_error_t *error)
{
    const sim_config_t *config = run->config;
    run->plant_config          = (sim_plant_config_t){.step_s                  = config->sample_time_s / run->steps,
                                                      .actuator_pole_rad_per_s = config->plant.actuator_pole_rad_per_s,
                                                      .sensor_pole_rad_per_s   = config->sensor.pole_rad_per_s,
                                                      .truth                   = {.friction = config->plant.friction,
                                                                                  .arm      = config->plant.arm,
                                                                                  .own      = config->plant.own[config->plant.model]}};
    if (!sim_sensor_init(&run->sensor, &config->sensor.sampling, run->plant_config.step_s))
    {
        return sim_error_set(error, "out of memory");
    }
    run->plant = sim_plant_create(&run->plant_config, sim_truth_models[config->plant.model]);
    return run->plant != NULL || sim_error_set(error, "out of memory");
}

static bool set_up_target(run_t *run, sim_error_t *error)
{
    if (run->options.target == NULL)
    {
        return true;
    }
    run->target = sim_target_start(run->options.target,
                                   run->options.q31,
                                   &run->loop_config.config,
                                   run->config->limits.full_scale_n,
                                   error);
    return run->target != NULL;
}

static bool set_up(run_t *run, const sim_scenario_t *scenario, const sim_run_options_t *options, sim_error_t *error)
{
    const sim_config_t *config = sim_scenario_config(scenario);
    *run                       = (run_t){.config  = config,
                                         .options = options != NULL ? *options : (sim_run_options_t){0},
                                         .ticks   = (uint64_t)round(config->duration_s / config->sample_time_s),
                                         .steps   = (unsigned)round(config->sample_time_s / config->plant.step_s)};
    sim_loop_config_fill(&run->loop_config, config);
    // A target has a loop of its own; this one then only checks the config.
    const bool           q31    = run->options.q31;
    const tribo_status_t status = sim_loop_init(&run->loop, q31, &run->loop_config.config, config->limits.full_scale_n);
    const bool ok = sim_check_status(scenario, status, error) && sim_reference_init(&run->reference, scenario, error) &&
                    set_up_plant(run, error) && set_up_target(run, error);
    if (!ok)
    {
        tear_down(run);
    }
    return ok;
}

/// One tick and the plant steps after it.
static bool advance(run_t *run, uint64_t tick, sim_row_t *row, sim_error_t *error)
{
    row->t_s     = (double)tick * run->config->sample_time_s;
    row->r_n     = sim_reference_at(&run->reference, row->t_s);
    row->force_n = sim_plant_force(run->plant);
    row->y_n     = sim_sensor_read(&run->sensor, sim_plant_filtered_force(run->plant));
    if (run->target == NULL)
    {
        row->u_n = sim_loop_step(&run->loop, row->r_n, row->y_n, &row->loop);
    }
    else if (!sim_target_step(run->target, row->r_n, row->y_n, &row->u_n, &row->loop, error))
    {
        return false;
    }
    row->q31 = NULL;

    sim_plant_signals_t later;
    for (unsigned step = 0; step < run->steps; step++)
    {
        sim_sensor_push(&run->sensor, sim_plant_filtered_force(run->plant));
        sim_plant_step(run->plant, row->u_n, step == 0 ? &row->plant : &later);
    }
    return true;
}

static bool in_window(const sim_config_t *config, const sim_row_t *row)
{
    const double end_s = config->metrics.end_s.is_given ? config->metrics.end_s.value : config->duration_s;
    // A tick at the window's edge counts as in at the start and as out at the end, rounding or not.
    const double t_s = row->t_s + 0.5 * config->sample_time_s;
    return t_s >= config->metrics.start_s && t_s <= end_s;
}

static void measure(metrics_t *metrics, const sim_row_t *row)
{
    const double error          = row->r_n - row->force_n;
    const double measured_error = row->r_n - row->y_n;
    metrics->error_squares += error * error;
    metrics->measured_squares += measured_error * measured_error;
    metrics->max_error_n = fmax(metrics->max_error_n, fabs(error));
    metrics->count++;
}

static void summarise(sim_summary_t *summary, const run_t *run, const metrics_t *metrics, double wall_s)
{
    const double count        = (metrics->count > 0) ? (double)metrics->count : 1.0;
    *summary                  = (sim_summary_t){.rms_error_n          = sqrt(metrics->error_squares / count),
                                                .max_error_n          = metrics->max_error_n,
                                                .rms_measured_error_n = sqrt(metrics->measured_squares / count),
                                                .ticks                = run->ticks,
                                                .limited_ticks        = sim_loop_limited_ticks(&run->loop),
                                                .bad_inputs           = sim_loop_bad_inputs(&run->loop),
                                                .simulated_s          = (double)run->ticks * run->config->sample_time_s,
                                                .wall_s               = wall_s};
    summary->real_time_factor = (wall_s > 0.0) ? summary->simulated_s / wall_s : 0.0;
}

static void compare(difference_t *difference, const sim_row_t *f32, const sim_row_t *q31)
{
    const double u     = q31->u_n - f32->u_n;
    const double force = q31->force_n - f32->force_n;
    difference->u_squares += u * u;
    difference->force_squares += force * force;
    difference->max_u_n     = fmax(difference->max_u_n, fabs(u));
    difference->max_force_n = fmax(difference->max_force_n, fabs(force));
}

static void summarise_beside(sim_beside_t       *beside,
                             const run_t        *run,
                             const metrics_t    *metrics,
                             const difference_t *difference)
{
    sim_summary_t whole;
    summarise(&whole, run, metrics, 0.0);
    const double count = (metrics->count > 0) ? (double)metrics->count : 1.0;
    *beside            = (sim_beside_t){.exists               = true,
                                        .rms_error_n          = whole.rms_error_n,
                                        .max_error_n          = whole.max_error_n,
                                        .rms_measured_error_n = whole.rms_measured_error_n,
                                        .limited_ticks        = whole.limited_ticks,
                                        .bad_inputs           = whole.bad_inputs,
                                        .max_u_n              = difference->max_u_n,
                                        .rms_u_n              = sqrt(difference->u_squares / count),
                                        .max_force_n          = difference->max_force_n,
                                        .rms_force_n          = sqrt(difference->force_squares / count)};
}

/// What the target counted and how it compares; nothing without one.
static bool finish_target(const run_t *run, sim_summary_t *summary, sim_error_t *error)
{
    if (run->target == NULL)
    {
        return true;
    }
    if (!sim_target_finish(run->target, &summary->lock_step, error))
    {
        return false;
    }
    summary->target        = run->options.target;
    summary->q31           = run->options.q31;
    summary->limited_ticks = summary->lock_step.limited_ticks;
    summary->bad_inputs    = summary->lock_step.bad_inputs;
    return true;
}

/// The loop, and the one in Q31 beside it when both are wanted.
typedef struct
{
    run_t        run[2];
    unsigned     count;
    metrics_t    metrics[2];
    difference_t difference;
} runs_t;

static bool set_up_all(runs_t                  *runs,
                       const sim_scenario_t    *scenario,
                       const sim_run_options_t *options,
                       sim_error_t             *error)
{
    const sim_run_options_t beside = {.q31 = true};
    *runs                          = (runs_t){.count = options != NULL && options->both ? 2u : 1u};
    if (!set_up(&runs->run[0], scenario, options, error))
    {
        return false;
    }
    if (runs->count == 2u && !set_up(&runs->run[1], scenario, &beside, error))
    {
        tear_down(&runs->run[0]);
        return false;
    }
    return true;
}

/// One tick of each.
static bool advance_all(runs_t *runs, uint64_t tick, sim_row_t rows[2], sim_error_t *error)
{
    const sim_config_t *config = runs->run[0].config;
    for (unsigned i = 0; i < runs->count; i++)
    {
        if (!advance(&runs->run[i], tick, &rows[i], error))
        {
            return false;
        }
        if (in_window(config, &rows[i]))
        {
            measure(&runs->metrics[i], &rows[i]);
        }
    }
    if (runs->count == 2u)
    {
        rows[0].q31 = &rows[1];
        if (in_window(config, &rows[0]))
        {
            compare(&runs->difference, &rows[0], &rows[1]);
        }
    }
    return true;
}

bool sim_run(const sim_scenario_t    *scenario,
             const sim_run_options_t *options,
             sim_row_handler_t        handler,
             void                    *context,
             sim_summary_t           *summary,
             sim_error_t             *error)
{
    const double start_s = sim_clock_s();
    runs_t       runs;
    if (!set_up_all(&runs, scenario, options, error))
    {
        return false;
    }
    const uint64_t ticks = runs.run[0].ticks;
    bool           ok    = true;
    for (uint64_t tick = 0; ok && tick < ticks; tick++)
    {
        sim_row_t rows[2];
        ok = advance_all(&runs, tick, rows, error);
        if (ok && handler != NULL)
        {
            ok = handler(context, rows, (double)tick / (double)ticks, error);
        }
    }
    summarise(summary, &runs.run[0], &runs.metrics[0], sim_clock_s() - start_s);
    ok = ok && finish_target(&runs.run[0], summary, error);
    if (runs.count == 2u)
    {
        summarise_beside(&summary->beside, &runs.run[1], &runs.metrics[1], &runs.difference);
        tear_down(&runs.run[1]);
    }
    tear_down(&runs.run[0]);
    return ok;
}
