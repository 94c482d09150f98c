// Runs a recorded log through the compensator: what it would have estimated on the user's own rig.

#include "cli/commands.h"
#include "cli/progress.h"
#include "cli/trace.h"
#include "scenario/check.h"
#include "scenario/loop.h"
#include "scenario/loop_config.h"
#include "support/csv.h"
#include "support/file.h"
#include "support/number.h"
#include "support/output_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define JITTER 0.01 ///< of the time stamps, as a fraction of an interval

typedef struct
{
    const char *log;
    const char *params; ///< null: the paper's
    const char *out;    ///< null: standard output
    bool        measured;
    bool        f32, q31; ///< what to run, one or both
    double      full_scale_n;
} options_t;

/// The compensator in both arithmetics; of Q31 the params are made only if it is wanted.
typedef struct
{
    const options_t               *options;
    double                         sample_time_s;
    tribo_compensator_f32_params_t f32;
    tribo_compensator_f32_state_t  state_f32;
    tribo_compensator_q31_params_t q31;
    tribo_compensator_q31_state_t  state_q31;
    tribo_breakaway_point_q31_t    table[TRIBO_BREAKAWAY_POINTS_MAX];
    uint64_t                       beyond_full_scale;    ///< rows
    double                         max_force_n, max_f_n; ///< largest differences
} replay_t;

enum
{
    COLUMN_T,
    COLUMN_U,
    COLUMN_F,
    COLUMN_COUNT
};

/// A recording cannot be made again: the result must not take its place, nor that of the params.
static int check_out(const options_t *options)
{
    const char *out = options->out;
    if (out != NULL && sim_file_is_same(out, options->log))
    {
        return sim_usage("replay: --out %s is the same file as the log %s", out, options->log);
    }
    if (out != NULL && options->params != NULL && sim_file_is_same(out, options->params))
    {
        return sim_usage("replay: --out %s is the same file as --params %s", out, options->params);
    }
    return 0;
}

enum
{
    OPTION_PARAMS = SIM_OPTION_FIRST,
    OPTION_FORCE,
    OPTION_OUT,
    OPTION_ARITH,
    OPTION_FULL_SCALE
};

// clang-format off: one row an option
static const struct argp_option known[] = {
    {.name = "params", .key = OPTION_PARAMS, .arg = "FILE.yaml", .doc = "keys of a scenario's `compensator`; the paper's values if left out"},
    {.name = "force", .key = OPTION_FORCE, .arg = "own|measured", .doc = "F is the compensator's own arm model's (if left out), or the log's F_N"},
    {.name = "out", .key = OPTION_OUT, .arg = "OUT.csv", .doc = "where the result goes; standard output if left out"},
    {.name = "arith", .key = OPTION_ARITH, .arg = "f32|q31|both", .doc = "f32 if left out; both: Q31's columns after f32's, and how they differ"},
    {.name = "full-scale", .key = OPTION_FULL_SCALE, .arg = "N", .doc = "what 2^31 stands for in Q31; 2 N if left out"},
    {.name = NULL}};
// clang-format on

static int take(void *context, int key, const char *value)
{
    options_t *options = context;
    int        word    = 0;
    switch (key)
    {
    case OPTION_PARAMS:
        options->params = value;
        return 0;
    case OPTION_FORCE:
        word              = sim_option_word(&sim_command_replay, key, value);
        options->measured = word == 1;
        break;
    case OPTION_OUT:
        options->out = value;
        return 0;
    case OPTION_ARITH:
        word         = sim_option_word(&sim_command_replay, key, value);
        options->f32 = word != 1;
        options->q31 = word != 0;
        break;
    default:
        return sim_number_parse(value, &options->full_scale_n) == NULL
                   ? 0
                   : sim_usage("--full-scale %s: a number of N is wanted", value);
    }
    return word >= 0 ? 0 : SIM_EXIT_USAGE;
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
static bool find_sample_time(const sim_csv_t *log, double *sample_time_s, sim_error_t *error)
{
    const double *t = log->values[COLUMN_T];
    if (log->rows < 2)
    {
        return sim_csv_complain(log, 0, error, "t_s: one row has no sample time, two at least are wanted");
    }
    const double median = median_interval(t, log->rows);
    if (!sim_csv_check_rising(log, "t_s", error) || median < 0.0)
    {
        return sim_error_set(error, "out of memory"); // if not said otherwise
    }
    for (size_t i = 1; i < log->rows; i++)
    {
        const double interval = t[i] - t[i - 1];
        if (!(fabs(interval - median) <= JITTER * median))
        {
            return sim_csv_complain(log,
                                    i,
                                    error,
                                    "t_s: %.6g s after the row before, where the log's interval is %.6g s",
                                    interval,
                                    median);
        }
    }
    *sample_time_s = (t[log->rows - 1] - t[0]) / (double)(log->rows - 1);
    return true;
}

static tribo_compensator_f32_signals_t step_f32(replay_t *replay, double u_n, double measured_n)
{
    tribo_compensator_f32_signals_t signals;
    if (replay->options->measured)
    {
        signals.force_n = (float)measured_n;
        (void)tribo_friction_f32_step(&replay->f32.friction,
                                      &replay->state_f32.friction,
                                      (float)u_n,
                                      signals.force_n,
                                      &signals.friction);
    }
    else
    {
        (void)tribo_compensator_f32_step(&replay->f32, &replay->state_f32, (float)u_n, &signals);
    }
    return signals;
}

/// What a step in Q31 saw, in newton and to float's seven digits.
static tribo_compensator_f32_signals_t signals_from_q31(const tribo_compensator_q31_signals_t *signals,
                                                        double                                 full_scale_n,
                                                        double                                 sample_time_s)
{
    const tribo_friction_q31_signals_t *friction = &signals->friction;
    return (tribo_compensator_f32_signals_t){
        .force_n  = (float)sim_n_from_q31(signals->force, full_scale_n),
        .friction = {.n_n       = (float)sim_n_from_q31(friction->n, full_scale_n),
                     .L_n       = (float)sim_n_from_q31(friction->L, full_scale_n),
                     .v_n_per_s = (float)(sim_n_from_q31(friction->rise, full_scale_n) / sample_time_s),
                     .f_n       = (float)sim_n_from_q31(friction->f, full_scale_n),
                     .relays    = friction->relays}};
}

static tribo_compensator_f32_signals_t step_q31(replay_t *replay, double u_n, double measured_n)
{
    const double                    full_scale_n = replay->options->full_scale_n;
    const int32_t                   u            = sim_q31_from_n(u_n, full_scale_n);
    tribo_compensator_q31_signals_t signals;
    replay->beyond_full_scale += fabs(u_n) > full_scale_n || fabs(measured_n) > full_scale_n;
    if (replay->options->measured)
    {
        signals.force = sim_q31_from_n(measured_n, full_scale_n);
        (void)tribo_friction_q31_step(&replay->q31.friction,
                                      &replay->state_q31.friction,
                                      u,
                                      signals.force,
                                      &signals.friction);
    }
    else
    {
        (void)tribo_compensator_q31_step(&replay->q31, &replay->state_q31, u, &signals);
    }
    return signals_from_q31(&signals, full_scale_n, replay->sample_time_s);
}

static void replay_row(replay_t *replay, const sim_csv_t *log, size_t row, FILE *file)
{
    const double                    u = log->values[COLUMN_U][row];
    const double                    F = replay->options->measured ? log->values[COLUMN_F][row] : 0.0;
    tribo_compensator_f32_signals_t f32;
    tribo_compensator_f32_signals_t q31;
    // 15 digits give a time stamp back as it was written, whatever its origin.
    (void)fprintf(file, "%.15g,%.9g,", log->values[COLUMN_T][row], u);
    if (replay->options->f32)
    {
        f32 = step_f32(replay, u, F);
        sim_trace_write_compensator(file, &f32);
    }
    if (replay->options->q31)
    {
        q31 = step_q31(replay, u, F);
        (void)fputs(replay->options->f32 ? "," : "", file);
        sim_trace_write_compensator(file, &q31);
    }
    if (replay->options->f32 && replay->options->q31)
    {
        replay->max_force_n = fmax(replay->max_force_n, fabs((double)q31.force_n - (double)f32.force_n));
        replay->max_f_n     = fmax(replay->max_f_n, fabs((double)q31.friction.f_n - (double)f32.friction.f_n));
    }
    (void)fputs("\n", file);
}

static const char q31_columns[] = ",F_hat_q31_N,n_q31_N,L_q31_N,v_q31_N_per_s,Q1_q31,Q2_q31,Q_q31,f_hat_q31_N";

static void step_through(replay_t *replay, const sim_csv_t *log, FILE *file)
{
    tribo_compensator_f32_reset(&replay->state_f32);
    tribo_compensator_q31_reset(&replay->state_q31);
    sim_progress_t progress = {.calls = 0};
    const bool     both     = replay->options->f32 && replay->options->q31;
    (void)fprintf(file, "t_s,u_N,%s%s\n", SIM_TRACE_COMPENSATOR, both ? q31_columns : "");
    for (size_t i = 0; i < log->rows && !ferror(file); i++)
    {
        replay_row(replay, log, i, file);
        sim_progress_update(&progress, (double)i / (double)log->rows);
    }
    sim_progress_end(&progress);
}

static void warn(const options_t *options, uint64_t rows, const char *of_what)
{
    if (rows > 0)
    {
        (void)
            fprintf(stderr, "tribo-sim: %s: warning: %u rows hold forces %s\n", options->log, (unsigned)rows, of_what);
    }
}

static bool replay_log(replay_t *replay, const sim_csv_t *log, sim_error_t *error)
{
    const options_t  *options = replay->options;
    sim_output_file_t file;
    if (!sim_output_open(&file, options->out, error))
    {
        return false;
    }
    step_through(replay, log, file.stream);
    if (!sim_output_commit(&file, 1, error))
    {
        return false;
    }
    warn(options, replay->state_f32.friction.bad_inputs, "too large for the compensator");
    warn(options, replay->beyond_full_scale, "beyond full scale");
    if (options->f32 && options->q31)
    {
        (void)fprintf(stderr, "largest Q31 - f32: F_hat %.3g N, f_hat %.3g N\n", replay->max_force_n, replay->max_f_n);
    }
    return true;
}

/// The compensator's params for the log's sample time.
static bool make_params(replay_t *replay, sim_scenario_t *scenario, sim_error_t *error)
{
    const options_t  *options = replay->options;
    sim_loop_config_t loop;
    if (options->params != NULL && !sim_scenario_load_compensator(scenario, options->params, error))
    {
        return false;
    }
    if (!sim_check_compensator(scenario, error))
    {
        return false;
    }
    sim_loop_config_fill(&loop, sim_scenario_config(scenario));
    const float    h      = (float)replay->sample_time_s;
    tribo_status_t status = tribo_compensator_f32_init(&replay->f32, &loop.config.compensator, h);
    if (status == TRIBO_OK && options->q31)
    {
        status = tribo_compensator_q31_init(&replay->q31,
                                            replay->table,
                                            &loop.config.compensator,
                                            h,
                                            (float)options->full_scale_n);
    }
    if (status == TRIBO_ERR_SAMPLE_TIME)
    {
        return sim_error_set(error,
                             "%s: its sample time is %.6g s; %s",
                             options->log,
                             replay->sample_time_s,
                             tribo_status_text(status));
    }
    if (status == TRIBO_ERR_FULL_SCALE)
    {
        return sim_error_set(error, "--full-scale %g: %s", options->full_scale_n, tribo_status_text(status));
    }
    return sim_check_status(scenario, status, error);
}

static bool replay_with(const options_t *options, sim_scenario_t *scenario, const sim_csv_t *log, sim_error_t *error)
{
    replay_t replay = {.options = options};
    return find_sample_time(log, &replay.sample_time_s, error) && make_params(&replay, scenario, error) &&
           replay_log(&replay, log, error);
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

static int run(int count, char **arguments)
{
    options_t   options = {.f32 = true, .full_scale_n = 2.0};
    sim_error_t error   = {""};
    int         status  = sim_options_parse(&sim_command_replay, count, arguments, &options, &options.log);
    if (status == 0)
    {
        status = check_out(&options);
    }
    if (status != 0)
    {
        return status;
    }
    return replay(&options, &error) ? SIM_EXIT_OK : sim_failure(error.text);
}

const sim_command_t sim_command_replay = {
    .name     = "replay",
    .argument = "LOG.csv",
    .noun     = "log",
    .text     = "Runs a recorded log (columns t_s, u_N and maybe F_N) through the friction compensator.",
    .options  = known,
    .run      = run,
    .take     = take};
