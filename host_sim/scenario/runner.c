#include "scenario/runner.h"

#include "loop/loop_config.h"
#include "loop/reference.h"
#include "scenario/check.h"
#include "scenario/plant_config.h"
#include "support/clock.h"
#include "target/target.h"

#include <inttypes.h>
#include <math.h>

#define DIVERGED 1e15 ///< N or N/s; no stable plant gets there from forces up to 1e6 N

/// Sums of squares and largest values over the metrics window.
typedef struct
{
    double   error_squares, measured_squares, max_error_n;
    uint64_t count;
} metrics_t;

/// A loop and its plant while a scenario runs.
typedef struct
{
    const sim_config_t *config;
    sim_run_options_t   options;
    common_reference_t  reference;
    sim_plant_config_t  plant_config;
    sim_plant_t        *plant;
    sim_sensor_t        sensor;

    common_loop_config_t loop_config;
    sim_loop_t           loop;
    sim_target_t        *target; ///< null: the loop runs on this host
    uint64_t             open_limited_ticks;
    sim_learned_t        learned;
    sim_idle_t           idle;
    double               low_n, high_n; ///< range of r
    metrics_t            metrics;
    sim_activity_t       activity;

    uint64_t ticks;
    unsigned steps; ///< plant steps in a tick
} run_t;

static void tear_down(run_t *run)
{
    common_reference_free(&run->reference);
    sim_plant_destroy(run->plant);
    sim_sensor_free(&run->sensor);
    sim_target_destroy(run->target);
}

static bool set_up_plant(run_t *run, common_error_t *error)
{
    const sim_config_t *config = run->config;
    run->plant_config          = sim_plant_config_of(config);
    if (!sim_sensor_init(&run->sensor, &config->sensor.sampling, run->plant_config.step_s))
    {
        return common_error_set(error, "out of memory");
    }
    run->plant = sim_plant_create(&run->plant_config, sim_truth_models[config->plant.model]);
    return run->plant != NULL || common_error_set(error, "out of memory");
}

static bool set_up_target(run_t *run, const common_scenario_t *scenario, common_error_t *error)
{
    if (run->options.target == NULL)
    {
        return true;
    }
    if (!sim_check_has_firmware(scenario, error))
    {
        return false;
    }
    run->target = sim_target_start(run->options.target,
                                   run->options.q31,
                                   &run->loop_config,
                                   run->config->loop.limits.full_scale_n,
                                   error);
    return run->target != NULL;
}

static bool set_up(run_t                   *run,
                   const common_scenario_t *scenario,
                   const sim_run_options_t *options,
                   common_error_t          *error)
{
    const sim_config_t *config = sim_scenario_config(scenario);
    *run                       = (run_t){.config  = config,
                                         .options = *options,
                                         .ticks   = (uint64_t)round(config->duration_s / config->loop.sample_time_s),
                                         .steps   = sim_plant_steps(config),
                                         .low_n   = (double)INFINITY,
                                         .high_n  = -(double)INFINITY};
    run->activity              = (sim_activity_t){.move_n = SIM_ACTIVITY_MOVE * config->loop.limits.full_scale_n};
    common_loop_config_fill(&run->loop_config, &config->loop);
    // A target has a loop of its own; this one only checks the config then.
    const bool           q31    = run->options.q31;
    const tribo_status_t status = sim_loop_init(&run->loop, q31, &run->loop_config, config->loop.limits.full_scale_n);
    const bool           ok     = common_check_status(scenario, status, error) &&
                    common_reference_init(&run->reference, scenario, error) && set_up_plant(run, error) &&
                    set_up_target(run, scenario, error);
    if (!ok)
    {
        tear_down(run);
    }
    return ok;
}

bool sim_run_learns(const sim_config_t *config)
{
    return config->loop.compensator.method == COMMON_METHOD_FEEDFORWARD &&
           config->loop.compensator.sensor != COMMON_SENSOR_NONE &&
           config->loop.controller.kind != COMMON_CONTROLLER_NONE;
}

/// Checks that a trace's values are finite, and far enough from overflow for the squares in a summary.
static bool check_row(const sim_row_t *row, common_error_t *error)
{
    const sim_truth_signals_t *truth = &row->plant.truth;
    const double               values[] =
        {row->force_n, row->y_n, row->u_n, row->plant.u_a_n, truth->n_n, truth->v_n_per_s, truth->L_n, truth->f_n};
    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++)
    {
        if (!(fabs(values[i]) <= DIVERGED))
        {
            return common_error_set(
                error,
                "the simulated plant diverges at t = %g s: plant.step_s is too long for its parameters",
                row->t_s);
        }
    }
    return true;
}

/// Plays an open loop: u is r within the limits, and the only signal of the loop is the command.
static void open_loop(const common_limits_config_t *limits, sim_row_t *row)
{
    row->u_n                     = fmin(fmax(row->r_n, limits->u_min_n), limits->u_max_n);
    row->loop                    = (tribo_force_loop_f32_signals_t){.e_n = (float)(row->r_n - row->y_n)};
    row->loop.controller.v_n     = (float)row->r_n;
    row->loop.controller.u_n     = (float)row->u_n;
    row->loop.controller.limited = row->u_n != row->r_n;
}

/// Returns the loop on this host, or the target's twin on this host, which has the same bits.
static const sim_loop_t *loop_of(const run_t *run)
{
    return run->target != NULL ? sim_target_twin(run->target) : &run->loop;
}

/// Counts a tick after the loop's step. `last` belongs to the tick before.
static void note_idle(run_t *run, const sim_row_t *row, double last_r_n, double last_force_n)
{
    const uint64_t bad  = sim_loop_bad_inputs(loop_of(run));
    sim_idle_t    *idle = &run->idle;
    if (bad > idle->bad_inputs)
    {
        idle->bad_inputs = bad;
    }
    else if (row->loop.controller.limited)
    {
        idle->limited++;
    }
    else if (row->r_n == last_r_n)
    {
        idle->standing++;
    }
    idle->travel_n += fabs(row->force_n - last_force_n);
}

/// Runs one tick and the plant steps after it. `row` was zeroed before the first tick, so values that a model or a loop does
/// not have stay 0.
static bool advance(run_t *run, uint64_t tick, sim_row_t *row, common_error_t *error)
{
    const double last_r_n     = row->r_n;
    const double last_force_n = row->force_n;

    row->t_s     = (double)tick * run->config->loop.sample_time_s;
    row->r_n     = common_reference_at(&run->reference, row->t_s);
    row->learned = sim_run_learns(run->config) ? &run->learned : NULL;
    row->force_n = sim_plant_force(run->plant);
    row->y_n     = sim_sensor_read(&run->sensor, sim_plant_filtered_force(run->plant));
    if (run->config->loop.controller.kind == COMMON_CONTROLLER_NONE)
    {
        open_loop(&run->config->loop.limits, row);
        run->open_limited_ticks += row->loop.controller.limited;
    }
    else if (run->target == NULL)
    {
        row->u_n = sim_loop_step(&run->loop, row->r_n, row->y_n, &row->loop);
        run->open_limited_ticks += run->loop_config.parts.is_sensorless && row->loop.controller.limited;
    }
    else if (!sim_target_step(run->target, row->r_n, row->y_n, &row->u_n, &row->loop, error))
    {
        return false;
    }
    if (row->learned != NULL)
    {
        run->learned = sim_loop_learned(loop_of(run), row->r_n);
        note_idle(run, row, last_r_n, last_force_n);
    }
    run->low_n  = fmin(run->low_n, row->r_n);
    run->high_n = fmax(run->high_n, row->r_n);
    sim_plant_signals_t later;
    for (unsigned step = 0; step < run->steps; step++)
    {
        sim_sensor_push(&run->sensor, sim_plant_filtered_force(run->plant));
        sim_plant_step(run->plant, row->u_n, step == 0 ? &row->plant : &later);
    }
    return check_row(row, error);
}

static bool in_window(const sim_config_t *config, const sim_row_t *row)
{
    const double end_s = config->metrics.end_s.is_given ? config->metrics.end_s.value : config->duration_s;
    // A tick at the edge of the window is inside at its start and outside at its end, whatever the rounding.
    const double t_s = row->t_s + 0.5 * config->loop.sample_time_s;
    return t_s >= config->metrics.start_s && t_s <= end_s;
}

static void measure(run_t *run, const sim_row_t *row)
{
    metrics_t   *metrics        = &run->metrics;
    const double error          = row->r_n - row->force_n;
    const double measured_error = row->r_n - row->y_n;
    metrics->error_squares += error * error;
    metrics->measured_squares += measured_error * measured_error;
    metrics->max_error_n = fmax(metrics->max_error_n, fabs(error));
    metrics->count++;
    sim_activity_add(&run->activity, row->r_n, row->u_n, (row->loop.compensator.friction.relays & TRIBO_RELAY_Q) != 0u);
}

/// Adds a tick's squares. The sums become the RMS at the end.
static void compare(sim_difference_t *difference, const sim_row_t *f32, const sim_row_t *q31)
{
    const double u     = q31->u_n - f32->u_n;
    const double force = q31->force_n - f32->force_n;
    difference->rms_u_n += u * u;
    difference->rms_force_n += force * force;
    difference->max_u_n     = fmax(difference->max_u_n, fabs(u));
    difference->max_force_n = fmax(difference->max_force_n, fabs(force));
}

static double mean_root(double squares, const metrics_t *metrics)
{
    return (metrics->count > 0) ? sqrt(squares / (double)metrics->count) : 0.0;
}

static sim_result_t result_of(const run_t *run)
{
    const metrics_t *metrics = &run->metrics;
    sim_result_t     result  = {.learns  = sim_run_learns(run->config),
                                .learned = run->learned,
                                .idle    = run->idle,
                                .usual_force_n = (double)tribo_force_loop_f32_usual_force_n(&run->loop_config.parts.config),
                                .rms_error_n          = mean_root(metrics->error_squares, metrics),
                                .max_error_n          = metrics->max_error_n,
                                .rms_measured_error_n = mean_root(metrics->measured_squares, metrics),
                                .activity             = run->activity,
                                .limited_ticks        = sim_loop_limited_ticks(&run->loop) + run->open_limited_ticks,
                                .bad_inputs           = sim_loop_bad_inputs(&run->loop),
                                .guard = loop_of(run)->guarded ? sim_loop_guard_text(loop_of(run)) : NULL};
    if (result.learns)
    {
        sim_loop_learned_breakaway(loop_of(run),
                                   &run->config->loop.compensator.friction.breakaway,
                                   run->low_n,
                                   run->high_n,
                                   &result.breakaway);
    }
    return result;
}

/// Takes the target's counters and its comparison with the host; does nothing without a target.
static bool finish_target(const run_t *run, sim_summary_t *summary, common_error_t *error)
{
    if (run->target == NULL)
    {
        return true;
    }
    if (!sim_target_finish(run->target, &summary->lock_step, error))
    {
        return false;
    }
    summary->target               = run->options.target;
    summary->q31                  = run->options.q31;
    summary->result.limited_ticks = summary->lock_step.limited_ticks;
    summary->result.bad_inputs    = summary->lock_step.bad_inputs;
    return true;
}

/// Runs one tick of each loop.
static bool advance_all(run_t *runs, unsigned count, uint64_t tick, sim_row_t *rows, common_error_t *error)
{
    for (unsigned i = 0; i < count; i++)
    {
        if (!advance(&runs[i], tick, &rows[i], error))
        {
            return false;
        }
        if (in_window(runs[i].config, &rows[i]))
        {
            measure(&runs[i], &rows[i]);
        }
    }
    rows[0].q31 = (count == 2u) ? &rows[1] : NULL;
    return true;
}

/// Runs from rest to the end.
static bool play(run_t            *runs,
                 unsigned          count,
                 sim_row_handler_t handler,
                 void             *context,
                 sim_difference_t *difference,
                 common_error_t   *error)
{
    sim_row_t rows[2] = {{.t_s = 0.0}};
    bool      ok      = true;
    for (uint64_t tick = 0; ok && tick < runs->ticks; tick++)
    {
        ok = advance_all(runs, count, tick, rows, error) &&
             (handler == NULL || handler(context, rows, (double)tick / (double)runs->ticks, error));
        if (ok && count == 2u && in_window(runs->config, rows))
        {
            compare(difference, &rows[0], &rows[1]);
        }
    }
    difference->rms_u_n     = mean_root(difference->rms_u_n, &runs->metrics);
    difference->rms_force_n = mean_root(difference->rms_force_n, &runs->metrics);
    return ok;
}

bool sim_run(const common_scenario_t *scenario,
             const sim_run_options_t *options,
             sim_row_handler_t        handler,
             void                    *context,
             sim_summary_t           *summary,
             common_error_t          *error)
{
    sim_run_options_t       chosen  = (options != NULL) ? *options : (sim_run_options_t){.target = NULL};
    const sim_run_options_t q31     = {.q31 = true};
    const double            start_s = common_clock_s();
    run_t                   runs[2];
    chosen.q31 = !chosen.both && (chosen.q31 || sim_scenario_config(scenario)->arithmetic == SIM_Q31);
    *summary   = (sim_summary_t){.both = chosen.both};
    if (!set_up(&runs[0], scenario, &chosen, error))
    {
        return false;
    }
    if (chosen.both && !set_up(&runs[1], scenario, &q31, error))
    {
        tear_down(&runs[0]);
        return false;
    }
    const unsigned count      = chosen.both ? 2u : 1u;
    bool           ok         = play(runs, count, handler, context, &summary->difference, error);
    summary->result           = result_of(&runs[0]);
    summary->result_q31       = result_of(&runs[count - 1]);
    summary->ticks            = runs->ticks;
    summary->simulated_s      = (double)runs->ticks * runs->config->loop.sample_time_s;
    summary->wall_s           = common_clock_s() - start_s;
    summary->real_time_factor = (summary->wall_s > 0.0) ? summary->simulated_s / summary->wall_s : 0.0;
    ok                        = ok && finish_target(&runs[0], summary, error);
    for (unsigned i = 0; i < count; i++)
    {
        tear_down(&runs[i]);
    }
    return ok;
}

bool sim_run_was_controlled(const common_scenario_t *scenario, const sim_summary_t *summary, common_error_t *error)
{
    const common_limits_config_t *limits = &common_scenario_loop(scenario)->limits;
    const uint64_t                bad    = summary->both && summary->result_q31.bad_inputs > summary->result.bad_inputs
                                               ? summary->result_q31.bad_inputs
                                               : summary->result.bad_inputs;
    return 10u * bad <= 9u * summary->ticks ||
           common_error_set(error,
                            "r or y was a bad input in %" PRIu64 " of %" PRIu64
                            " ticks, beyond limits.input_max_N (%g N; u %g to %g N), where e counts as 0. Are all "
                            "forces in N, and are the limits your rig's?",
                            bad,
                            summary->ticks,
                            limits->input_max_n,
                            limits->u_min_n,
                            limits->u_max_n);
}
