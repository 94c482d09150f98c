#include "cli/commands.h"
#include "cli/progress.h"
#include "cli/scenario_folder.h"
#include "cli/trace.h"
#include "scenario/runner.h"
#include "support/output_file.h"

#include <getopt.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

typedef struct
{
    sim_scenario_choice_t choice;
    const char           *folder; ///< null: write nothing
    bool                  json;

    sim_run_options_t run;
} options_t;

/// Takes the command line; 0, or the status to exit with.
static int take_options(options_t *options, int count, char **arguments)
{
    static const struct option known[] = {{"set", required_argument, NULL, 's'},
                                          {"out", required_argument, NULL, 'o'},
                                          {"json", no_argument, NULL, 'j'},
                                          {"target", required_argument, NULL, 't'},
                                          {"arith", required_argument, NULL, 'a'},
                                          {NULL, 0, NULL, 0}};

    opterr = 0;
    int letter;
    int status;
    while ((letter = getopt_long(count, arguments, ":", known, NULL)) != -1)
    {
        switch (letter)
        {
        case 's':
            status = sim_scenario_take_set(&options->choice, optarg);
            if (status != 0)
            {
                return status;
            }
            break;
        case 'o':
            options->folder = optarg;
            break;
        case 'j':
            options->json = true;
            break;
        case 't':
            if (!sim_target_exists(optarg))
            {
                return sim_usage("--target %s: there are %s", optarg, sim_target_names());
            }
            options->run.target = optarg;
            break;
        case 'a':
            options->run.q31  = strcmp(optarg, "q31") == 0;
            options->run.both = strcmp(optarg, "both") == 0;
            if (!options->run.q31 && !options->run.both && strcmp(optarg, "f32") != 0)
            {
                return sim_usage("--arith %s: there are f32, q31, both", optarg);
            }
            break;
        case ':':
            return sim_usage("run: %s wants a value", arguments[optind - 1]);
        default:
            return sim_usage("run: unknown option %s", arguments[optind - 1]);
        }
    }
    if (optind + 1 != count)
    {
        return sim_usage("run: one scenario is wanted, not %d", count - optind);
    }
    if (options->run.both && options->run.target != NULL)
    {
        return sim_usage("--arith both does not go with --target");
    }
    options->choice.name = arguments[optind];
    return 0;
}

typedef struct
{
    sim_progress_t    progress;
    sim_output_file_t trace;
    sim_output_file_t beside; ///< Q31's, when both run
} recorder_t;

static bool write_row(sim_output_file_t *file, const sim_row_t *row, sim_error_t *error)
{
    sim_trace_write_row(file->stream, row);
    return !ferror(file->stream) || sim_output_file_commit(file, error); // which says why, and fails
}

static bool record(void *context, const sim_row_t *row, double part_done, sim_error_t *error)
{
    recorder_t *recorder = context;
    sim_progress_update(&recorder->progress, part_done);
    if (recorder->trace.stream != NULL && !write_row(&recorder->trace, row, error))
    {
        return false;
    }
    if (recorder->beside.stream != NULL && !write_row(&recorder->beside, row->q31, error))
    {
        return false;
    }
    return true;
}

static char *join(const char *folder, const char *name)
{
    const size_t size = strlen(folder) + strlen(name) + 2;
    char        *path = malloc(size);
    if (path != NULL)
    {
        (void)snprintf(path, size, "%s/%s", folder, name);
    }
    return path;
}

static bool open_in_folder(sim_output_file_t *file, const char *folder, const char *name, sim_error_t *error)
{
    char *path = join(folder, name);
    if (path == NULL)
    {
        (void)sim_error_set(error, "out of memory");
        return false;
    }
    const bool ok = sim_output_file_open(file, path, error);
    free(path);
    return ok;
}

static bool open_trace(sim_output_file_t *file, const char *folder, const char *name, sim_error_t *error)
{
    if (!open_in_folder(file, folder, name, error))
    {
        return false;
    }
    sim_trace_write_header(file->stream);
    return true;
}

/// Puts the traces in their places. One of Q31 that an earlier run has left would not belong to the new summary.
static bool commit_traces(recorder_t *recorder, const options_t *options, sim_error_t *error)
{
    if (!sim_output_file_commit(&recorder->trace, error))
    {
        return false;
    }
    if (options->run.both)
    {
        return sim_output_file_commit(&recorder->beside, error);
    }
    char *stale = join(options->folder, "trace_q31.csv");
    if (stale == NULL)
    {
        return sim_error_set(error, "out of memory");
    }
    const bool ok = sim_output_file_remove(stale, error);
    free(stale);
    return ok;
}

static bool simulate(const sim_scenario_t *scenario,
                     const options_t      *options,
                     sim_summary_t        *summary,
                     sim_error_t          *error)
{
    recorder_t recorder = {.trace = {0}, .beside = {0}};
    bool       ok       = true;
    if (options->folder != NULL)
    {
        ok = sim_output_folder_create(options->folder, error) &&
             open_trace(&recorder.trace, options->folder, "trace.csv", error) &&
             (!options->run.both || open_trace(&recorder.beside, options->folder, "trace_q31.csv", error));
    }
    sim_progress_start(&recorder.progress);
    ok = ok && sim_run(scenario, &options->run, record, &recorder, summary, error);
    sim_progress_end(&recorder.progress);
    if (ok && options->folder != NULL)
    {
        ok = commit_traces(&recorder, options, error);
    }
    sim_output_file_discard(&recorder.trace);
    sim_output_file_discard(&recorder.beside);
    return ok;
}

static bool write_summary(const char *folder, const char *json, sim_error_t *error)
{
    char *path = join(folder, "summary.json");
    if (path == NULL)
    {
        return sim_error_set(error, "out of memory");
    }
    const bool ok = sim_output_file_write_line(path, json, error);
    free(path);
    return ok;
}

static void print_table(const sim_summary_t *summary, const options_t *options)
{
    (void)printf("%-26s%.6f N\n", "RMS error, r - F", summary->rms_error_n);
    (void)printf("%-26s%.6f N\n", "largest error, r - F", summary->max_error_n);
    (void)printf("%-26s%.6f N\n", "RMS measured error, r - y", summary->rms_measured_error_n);
    (void)printf("%-26s%" PRIu64 " (limited %" PRIu64 ", bad inputs %" PRIu64 ")\n",
                 "ticks",
                 summary->ticks,
                 summary->limited_ticks,
                 summary->bad_inputs);
    (void)printf("%-26s%g s in %.3f s, %.0f times real time\n",
                 "simulated",
                 summary->simulated_s,
                 summary->wall_s,
                 summary->real_time_factor);
    if (summary->target != NULL)
    {
        (void)printf("%-26s%s, %s: %s, %.0f ticks a second in lock-step\n",
                     "target",
                     summary->target,
                     summary->q31 ? "q31" : "f32",
                     summary->lock_step.different_ticks == 0 ? "the same bits as the host" : "differs from the host",
                     summary->lock_step.ticks_per_s);
    }
    if (summary->beside.exists)
    {
        (void)printf("%-26s%.6f N\n", "RMS error in Q31", summary->beside.rms_error_n);
        (void)printf("%-26su %.3g N, F %.3g N (RMS %.3g, %.3g)\n",
                     "largest Q31 - f32",
                     summary->beside.max_u_n,
                     summary->beside.max_force_n,
                     summary->beside.rms_u_n,
                     summary->beside.rms_force_n);
    }
    if (options->folder != NULL)
    {
        (void)printf("%-26s%s/trace.csv, ", "written", options->folder);
        if (options->run.both)
        {
            (void)printf("%s/trace_q31.csv, ", options->folder);
        }
        (void)printf("%s/summary.json\n", options->folder);
    }
}

/// Shows and writes the results.
static bool report(const sim_summary_t *summary, const options_t *options, sim_error_t *error)
{
    char *json = sim_summary_to_json(summary);
    if (json == NULL)
    {
        return sim_error_set(error, "out of memory");
    }
    bool ok = options->folder == NULL || write_summary(options->folder, json, error);
    if (ok && options->json)
    {
        (void)puts(json);
    }
    else if (ok)
    {
        print_table(summary, options);
    }
    free(json);
    return ok && sim_output_flush(error);
}

/// Last, so that what differs can be looked at in the files.
static bool is_identical(const sim_summary_t *summary, sim_error_t *error)
{
    return summary->target == NULL || summary->lock_step.different_ticks == 0 ||
           sim_error_set(error, "%s", summary->lock_step.difference);
}

static bool run(const options_t *options, sim_error_t *error)
{
    sim_scenario_t *scenario = sim_scenario_create();
    sim_summary_t   summary;
    if (scenario == NULL)
    {
        return sim_error_set(error, "out of memory");
    }
    const bool ok = sim_scenario_open(scenario, &options->choice, error) &&
                    simulate(scenario, options, &summary, error) && report(&summary, options, error) &&
                    is_identical(&summary, error);
    sim_scenario_destroy(scenario);
    return ok;
}

int sim_command_run(int count, char **arguments)
{
    options_t options = {.choice.sets = (char **)calloc((size_t)count, sizeof *options.choice.sets)};
    if (options.choice.sets == NULL)
    {
        return sim_failure("out of memory");
    }
    int status = take_options(&options, count, arguments);
    if (status == 0)
    {
        sim_error_t error = {""};
        status            = run(&options, &error) ? SIM_EXIT_OK : sim_failure(error.text);
    }
    free((void *)options.choice.sets);
    return status;
}
