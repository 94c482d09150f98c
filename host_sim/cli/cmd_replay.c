// Runs a recorded log through the compensator: what it would have estimated on the user's own rig.

#include "cli/commands.h"
#include "cli/progress.h"
#include "scenario/check.h"
#include "scenario/loop_config.h"
#include "support/csv.h"
#include "support/output_file.h"
#include "tribo/compensator_f32.h"

#include <getopt.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define JITTER 0.01 ///< of an interval, in parts of it

typedef struct
{
    const char *log;
    const char *params; ///< null: the paper's
    const char *out;    ///< null: standard output
    bool        measured;
} options_t;

enum
{
    COLUMN_T,
    COLUMN_U,
    COLUMN_F,
    COLUMN_COUNT
};

static int take_options(options_t *options, int count, char **arguments)
{
    static const struct option known[] = {{"params", required_argument, NULL, 'p'},
                                          {"force", required_argument, NULL, 'f'},
                                          {"out", required_argument, NULL, 'o'},
                                          {NULL, 0, NULL, 0}};

    opterr = 0;
    int letter;
    while ((letter = getopt_long(count, arguments, ":", known, NULL)) != -1)
    {
        switch (letter)
        {
        case 'p':
            options->params = optarg;
            break;
        case 'f':
            options->measured = strcmp(optarg, "measured") == 0;
            if (!options->measured && strcmp(optarg, "own") != 0)
            {
                return sim_usage("replay: --force is own or measured, not %s", optarg);
            }
            break;
        case 'o':
            options->out = optarg;
            break;
        case ':':
            return sim_usage("replay: %s wants a value", arguments[optind - 1]);
        default:
            return sim_usage("replay: unknown option %s", arguments[optind - 1]);
        }
    }
    if (optind + 1 != count)
    {
        return sim_usage("replay: one log is wanted, not %d", count - optind);
    }
    options->log = arguments[optind];
    return 0;
}

static int compare_numbers(const void *a, const void *b)
{
    double x, y;
    memcpy(&x, a, sizeof x);
    memcpy(&y, b, sizeof y);
    return (x > y) - (x < y);
}

/// The middle one of the intervals, which no gap moves; negative if there is no memory.
static double median_interval(const double *t, size_t rows)
{
    const size_t count     = rows - 1;
    double      *intervals = malloc(count * sizeof *intervals);
    if (intervals == NULL)
    {
        return -1.0;
    }
    for (size_t i = 0; i < count; i++)
    {
        intervals[i] = t[i + 1] - t[i];
    }
    qsort(intervals, count, sizeof *intervals, compare_numbers);
    const double median = intervals[count / 2];
    free(intervals);
    return median;
}

/// The sample time that the time stamps keep, all of them.
static bool find_sample_time(const sim_csv_t *log, const char *path, double *sample_time_s, sim_error_t *error)
{
    const double *t = log->values[COLUMN_T];
    if (log->rows < 2)
    {
        return sim_error_set(error,
                             "%s:%zu:%zu: t_s: one row has no sample time, two at least are wanted",
                             path,
                             log->lines[0],
                             log->positions[0]);
    }
    for (size_t i = 1; i < log->rows; i++)
    {
        if (!(t[i] > t[i - 1]))
        {
            return sim_error_set(error,
                                 "%s:%zu:%zu: t_s: %.15g does not come after %.15g",
                                 path,
                                 log->lines[i],
                                 log->positions[i],
                                 t[i],
                                 t[i - 1]);
        }
    }
    const double median = median_interval(t, log->rows);
    if (median < 0.0)
    {
        return sim_error_set(error, "out of memory");
    }
    for (size_t i = 1; i < log->rows; i++)
    {
        const double interval = t[i] - t[i - 1];
        if (!(fabs(interval - median) <= JITTER * median))
        {
            return sim_error_set(error,
                                 "%s:%zu:%zu: t_s: %.6g s after the row before, where the log's interval is %.6g s",
                                 path,
                                 log->lines[i],
                                 log->positions[i],
                                 interval,
                                 median);
        }
    }
    *sample_time_s = (t[log->rows - 1] - t[0]) / (double)(log->rows - 1);
    return true;
}

static void write_header(FILE *file)
{
    (void)fputs("t_s,u_N,F_hat_N,n_N,L_N,v_N_per_s,Q1,Q2,Q,f_hat_N\n", file);
}

static void write_row(FILE *file, double t, double u, const tribo_compensator_f32_signals_t *signals)
{
    const tribo_friction_f32_signals_t *friction = &signals->friction;
    // 15 digits give a time stamp back as it was written, whatever its origin.
    (void)fprintf(file,
                  "%.15g,%.9g,%.9g,%.9g,%.9g,%.9g,%d,%d,%d,%.9g\n",
                  t,
                  u,
                  (double)signals->force_n,
                  (double)friction->n_n,
                  (double)friction->L_n,
                  (double)friction->v_n_per_s,
                  friction->q1 ? 1 : 0,
                  friction->q2 ? 1 : 0,
                  friction->q ? 1 : 0,
                  (double)friction->f_n);
}

/// Steps through the log; returns how many rows the compensator found bad.
static uint32_t step_through(const sim_csv_t                      *log,
                             const tribo_compensator_f32_params_t *params,
                             bool                                  measured,
                             FILE                                 *file)
{
    tribo_compensator_f32_state_t state;
    tribo_compensator_f32_reset(&state);
    sim_progress_t progress;
    sim_progress_start(&progress);
    write_header(file);
    for (size_t i = 0; i < log->rows && !ferror(file); i++)
    {
        tribo_compensator_f32_signals_t signals;
        const float                     u = (float)log->values[COLUMN_U][i];
        if (measured)
        {
            signals.force_n = (float)log->values[COLUMN_F][i];
            (void)tribo_friction_f32_step(&params->friction, &state.friction, u, signals.force_n, &signals.friction);
        }
        else
        {
            (void)tribo_compensator_f32_step(params, &state, u, &signals);
        }
        write_row(file, log->values[COLUMN_T][i], log->values[COLUMN_U][i], &signals);
        sim_progress_update(&progress, (double)i / (double)log->rows);
    }
    sim_progress_end(&progress);
    return state.friction.bad_inputs;
}

static bool replay_log(const options_t                      *options,
                       const sim_csv_t                      *log,
                       const tribo_compensator_f32_params_t *params,
                       sim_error_t                          *error)
{
    sim_output_file_t file;
    if (!sim_output_file_open(&file, options->out, error))
    {
        return false;
    }
    const uint32_t bad = step_through(log, params, options->measured, file.stream);
    if (!sim_output_file_commit(&file, error))
    {
        return false;
    }
    if (bad > 0)
    {
        (void)fprintf(stderr,
                      "tribo-sim: %s: warning: %u rows hold forces too large for the compensator\n",
                      options->log,
                      (unsigned)bad);
    }
    return true;
}

/// The compensator's params for the log's sample time.
static bool make_params(const options_t                *options,
                        sim_scenario_t                 *scenario,
                        sim_loop_config_t              *loop,
                        double                          sample_time_s,
                        tribo_compensator_f32_params_t *params,
                        sim_error_t                    *error)
{
    if (options->params != NULL && !sim_scenario_load_compensator(scenario, options->params, error))
    {
        return false;
    }
    if (!sim_check_ranges(scenario, error) || !sim_check_compensator(scenario, error))
    {
        return false;
    }
    sim_loop_config_fill(loop, sim_scenario_config(scenario));
    const tribo_status_t status = tribo_compensator_f32_init(params, &loop->config.compensator, (float)sample_time_s);
    if (status == TRIBO_ERR_SAMPLE_TIME)
    {
        return sim_error_set(error,
                             "%s: its sample time is %.6g s; %s",
                             options->log,
                             sample_time_s,
                             tribo_status_text(status));
    }
    return sim_check_status(scenario, status, error);
}

static bool replay_with(const options_t *options, sim_scenario_t *scenario, const sim_csv_t *log, sim_error_t *error)
{
    double                         sample_time_s = 0.0;
    sim_loop_config_t              loop;
    tribo_compensator_f32_params_t params;
    return find_sample_time(log, options->log, &sample_time_s, error) &&
           make_params(options, scenario, &loop, sample_time_s, &params, error) &&
           replay_log(options, log, &params, error);
}

static bool replay(const options_t *options, sim_error_t *error)
{
    const sim_csv_column_t columns[COLUMN_COUNT] = {[COLUMN_T] = {.name = "t_s"},
                                                    [COLUMN_U] = {.name = "u_N"},
                                                    [COLUMN_F] = {.name = "F_N", .optional = !options->measured}};
    sim_csv_t              log;
    if (!sim_csv_read(&log, options->log, columns, COLUMN_COUNT, error))
    {
        return false;
    }
    sim_scenario_t *scenario = sim_scenario_create();
    const bool      ok =
        (scenario != NULL) ? replay_with(options, scenario, &log, error) : sim_error_set(error, "out of memory");
    sim_scenario_destroy(scenario);
    sim_csv_free(&log);
    return ok;
}

int sim_command_replay(int count, char **arguments)
{
    options_t options = {0};
    const int status  = take_options(&options, count, arguments);
    if (status != 0)
    {
        return status;
    }
    sim_error_t error = {""};
    return replay(&options, &error) ? SIM_EXIT_OK : sim_failure(error.text);
}
