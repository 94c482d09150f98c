#include "commit.h"
#include "loop/effective.h"
#include "scenario/runner.h"
#include "sim/commands.h"
#include "sim/learned.h"
#include "sim/picture.h"
#include "sim/progress.h"
#include "sim/scenario_choice.h"
#include "sim/trace.h"
#include "support/file.h"
#include "support/number.h"
#include "support/output_file.h"
#include "support/text.h"

#include "tribo/status.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct
{
    sim_scenario_choice_t choice;
    const char           *folder;    ///< null: write nothing
    const char           *plot;      ///< null: no picture
    char                 *temporary; ///< the folder, where there is a picture but no --out
    bool                  whole_plot;
    bool                  json;
    sim_trace_choice_t    trace;

    int    count; ///< of the command line's arguments
    char **arguments;

    sim_run_options_t run;
} options_t;

enum
{
    OPTION_SET = SIM_OPTION_FIRST,
    OPTION_LEARNED,
    OPTION_OUT,
    OPTION_PLOT,
    OPTION_ALL,
    OPTION_DECIMATE,
    OPTION_COLUMNS,
    OPTION_JSON,
    OPTION_TARGET,
    OPTION_ARITH
};

// clang-format off: one row an option
static const struct argp_option known[] = {
    {.name = "set", .key = OPTION_SET, .arg = "KEY=VALUE", .doc = "changes any key, e.g. compensator.gain=0"},
    {.name = "learned", .key = OPTION_LEARNED, .arg = "FILE.yaml", .doc = "starts with the breakaway that an earlier run has learned (its DIR/learned.yaml)"},
    {.name = "out", .key = OPTION_OUT, .arg = "DIR", .doc = "writes DIR/trace.csv (one row a tick), DIR/summary.json, DIR/scenario.yaml, which plays the same run again, and, where breakaway is learned, DIR/learned.yaml"},
    {.name = "plot", .key = OPTION_PLOT, .arg = "FILE.png|svg|html", .doc = "draws the run (see `plot`; needs Python and matplotlib)"},
    {.name = "all", .key = OPTION_ALL, .doc = "also draws learned values, relays and friction over net force"},
    {.name = "decimate", .key = OPTION_DECIMATE, .arg = "N", .doc = "writes only the first of every N rows of a trace"},
    {.name = "columns", .key = OPTION_COLUMNS, .arg = "NAME,...", .doc = "writes only these columns of a trace, and t_s"},
    {.name = "json", .key = OPTION_JSON, .doc = "prints the summary as JSON instead of a table"},
    {.name = "arith", .key = OPTION_ARITH, .arg = "f32|q31|both", .doc = "the scenario's if left out, f32 in most; both runs two loops on two plants and compares them"},
    {.name = "target", .key = OPTION_TARGET, .arg = "NAME", .doc = "runs the drive's firmware on an emulated microcontroller, or on a board at a serial line, against the plant here, and compares it with the host, bit by bit"},
    {.name = NULL}};
// clang-format on

/// The setting of --arith, which also goes into the scenario in DIR.
static const char *const arithmetic[] = {"arithmetic=f32", "arithmetic=q31", "arithmetic=both"};

static int take(void *context, int key, const char *value)
{
    options_t     *options = context;
    common_error_t error   = {""};
    int            word    = 0;
    switch (key)
    {
    case OPTION_SET:
        return sim_scenario_take_set(&options->choice, value);
    case OPTION_LEARNED:
        options->choice.learned = value;
        return 0;
    case OPTION_OUT:
        options->folder = value;
        return 0;
    case OPTION_PLOT:
        options->plot = value;
        return sim_picture_has_ending(value)
                   ? 0
                   : sim_usage("--plot %s: a name that ends in .png, .svg or .html is expected", value);
    case OPTION_ALL:
        options->whole_plot = true;
        return 0;
    case OPTION_DECIMATE:
        return common_number_parse_whole(value, &options->trace.every) == NULL && options->trace.every > 0u
                   ? 0
                   : sim_usage("--decimate %s: a whole number of 1 or more is expected", value);
    case OPTION_COLUMNS:
        return sim_trace_choose(&options->trace, value, &error) ? 0 : sim_usage("--columns: %s", error.text);
    case OPTION_JSON:
        options->json = true;
        return 0;
    case OPTION_TARGET:
        options->run.target = value;
        return sim_target_exists(value) ? 0 : sim_usage("--target %s: must be one of %s", value, sim_target_names());
    default:
        word = sim_option_word(&sim_command_run, key, value);
        return word >= 0 ? sim_scenario_take_set(&options->choice, arithmetic[word]) : SIM_EXIT_USAGE;
    }
}

// --- results -------------------------------------------------------------------------------------------------------

enum
{
    TRACE,
    TRACE_Q31,
    LEARNED,
    SCENARIO,
    SUMMARY, ///< last: its presence shows that the others are complete
    FILES
};

typedef struct
{
    sim_progress_t            progress;
    const sim_trace_choice_t *trace;
    uint64_t                  rows; ///< written so far
    common_output_file_t      file[FILES];
} recorder_t;

static bool write_row(common_output_file_t     *file,
                      const sim_trace_choice_t *trace,
                      const sim_row_t          *row,
                      common_error_t           *error)
{
    if (file->stream == NULL || row == NULL)
    {
        return true;
    }
    sim_trace_write_row(file->stream, trace, row);
    return !ferror(file->stream) || common_output_commit(file, 1, error); // reports the write error and fails
}

static bool record(void *context, const sim_row_t *row, double part_done, common_error_t *error)
{
    recorder_t *recorder = context;
    sim_progress_update(&recorder->progress, part_done);
    if (recorder->trace->every > 0u && recorder->rows++ % recorder->trace->every != 0u)
    {
        return true;
    }
    return write_row(&recorder->file[TRACE], recorder->trace, row, error) &&
           write_row(&recorder->file[TRACE_Q31], recorder->trace, row->q31, error);
}

static const char *const file_names[FILES] = {"trace.csv",
                                              "trace_q31.csv",
                                              "learned.yaml",
                                              "scenario.yaml",
                                              "summary.json"};

/// Refuses results in the place of the scenario, of its reference, or of what is learned.
static bool check_results(const common_scenario_t *scenario, const options_t *options, common_error_t *error)
{
    char             *path      = sim_scenario_path(options->choice.name);
    char             *reference = common_scenario_reference_path(scenario);
    const char *const inputs[]  = {path, reference, options->choice.learned};
    const size_t      count     = sizeof inputs / sizeof inputs[0];
    bool              ok = options->plot == NULL || common_file_check_result(options->plot, inputs, count, error);
    for (int i = 0; ok && options->folder != NULL && i < FILES; i++)
    {
        char *result = common_text_format("%s/%s", options->folder, file_names[i]);
        ok           = result == NULL || common_file_check_result(result, inputs, count, error);
        free(result);
    }
    free(path);
    free(reference);
    return ok;
}

/// Opens the run's files in the folder, and removes the Q31 trace of an earlier run.
static bool open_files(recorder_t *recorder, const options_t *options, bool learns, common_error_t *error)
{
    bool ok = common_output_folder_create(options->folder, error);
    for (int i = 0; ok && i < FILES; i++)
    {
        const bool wanted = (i != TRACE_Q31 || options->run.both) && (i != LEARNED || learns);
        char      *path   = common_text_format("%s/%s", options->folder, file_names[i]);
        ok = path != NULL ? (wanted ? common_output_open : common_output_expect_none)(&recorder->file[i], path, error)
                          : common_error_set(error, "out of memory");
        free(path);
        if (ok && wanted && i < LEARNED)
        {
            sim_trace_write_header(recorder->file[i].stream, &options->trace, learns);
        }
    }
    return ok;
}

/// The scenario as played, below the command that played it.
static bool write_scenario(FILE                    *stream,
                           const common_scenario_t *scenario,
                           const options_t         *options,
                           common_error_t          *error)
{
    (void)fputs("# tribo-sim " TRIBO_VERSION_STRING SIM_AT_COMMIT ", tribo-sim", stream);
    for (int i = 0; i < options->count; i++)
    {
        (void)fputc(' ', stream);
        for (const char *c = options->arguments[i]; *c != '\0'; c++)
        {
            (void)fputc((unsigned char)*c < ' ' ? ' ' : *c, stream); // stays one line
        }
    }
    (void)fputc('\n', stream);
    return common_scenario_write(stream, scenario, error);
}

/// Runs the scenario and writes the requested files into the folder. Returns the summary as JSON, or null.
static char *simulate(const common_scenario_t *scenario,
                      const options_t         *options,
                      sim_summary_t           *summary,
                      common_error_t          *error)
{
    recorder_t recorder = {.trace = &options->trace};
    char      *json;
    const bool learns = sim_run_learns(sim_scenario_config(scenario));
    bool       ok     = sim_trace_check(&options->trace, learns, error) &&
              (options->folder == NULL || open_files(&recorder, options, learns, error));
    ok = ok && sim_run(scenario, &options->run, record, &recorder, summary, error);
    sim_progress_end(&recorder.progress);
    json = ok ? sim_summary_to_json(summary) : NULL;
    if (json == NULL)
    {
        (void)common_error_set(error, "out of memory"); // unless an error is set already
    }
    else if (options->folder != NULL)
    {
        (void)fprintf(recorder.file[SUMMARY].stream, "%s\n", json);
        if (learns)
        {
            sim_learned_write(recorder.file[LEARNED].stream, &summary->result);
        }
        ok = write_scenario(recorder.file[SCENARIO].stream, scenario, options, error) &&
             common_output_commit(recorder.file, FILES, error);
    }
    common_output_discard(recorder.file, FILES);
    if (!ok)
    {
        free(json);
        json = NULL;
    }
    return json;
}

static void print_activity(const char *where, const sim_activity_t *activity)
{
    (void)printf("u varies%-18s%.4g N, r %.4g N; chatter in %" PRIu64 " of %" PRIu64 " ticks, Q switches %" PRIu64
                 " times\n",
                 where,
                 activity->u_variation_n,
                 activity->r_variation_n,
                 activity->chatter_ticks,
                 activity->ticks,
                 activity->q_switches);
}

#define APART 0.2 // fraction of L: a smaller difference of the learned directions is not reported
#define KNOWN 0.1 // relative variance below which a direction is learned

/// At forces of one sign u and F cannot separate friction that differs by direction from a wrong scale or bias of u.
static void print_apart(const sim_result_t *result)
{
    const double *const breakaway = result->learned.breakaway_n;
    const double *const variance  = result->learned.relative_variance;
    if (result->learns && fmax(variance[0], variance[1]) < KNOWN &&
        fabs(breakaway[0] - breakaway[1]) > APART * 0.5 * (breakaway[0] + breakaway[1]))
    {
        (void)printf("%-26sL+ is %.2f of L-: friction differs by direction, or the scale or bias of u is off\n",
                     "learned apart",
                     breakaway[0] / breakaway[1]);
    }
}

static void print_learned(const sim_result_t *result, uint64_t ticks)
{
    char                     why[SIM_NOT_LEARNED_SIZE];
    static const char *const names[] = {"positive", "negative"};
    for (int d = 0; result->learns && d < 2; d++)
    {
        (void)printf("learned, %-17s%.4f N at the last r, relative variance %.3f, from %.3g N of travel%s\n",
                     names[d],
                     result->learned.breakaway_n[d],
                     result->learned.relative_variance[d],
                     result->learned.travel_n[d],
                     result->learned.stays_at_bound[d] ? ", stays at a bound: do not trust it"
                     : result->learned.at_bound[d]     ? ", at a bound: do not trust it"
                                                       : "");
    }
    if (result->learns)
    {
        (void)printf("%-26s%.4g N: breakaway there sets the widths\n", "usual force", result->usual_force_n);
    }
    if (sim_summary_not_learned(result, ticks, why))
    {
        (void)printf("%-26s%s\n", "learned too little", why);
    }
    print_apart(result);
    if (result->learned.harms)
    {
        (void)printf("%-26s%s\n",
                     "friction was fed back",
                     "when fed forward it cost the controller more effort than it saved");
    }
    if (result->learned.forgotten > 0u)
    {
        (void)printf("%-26s%" PRIu32 " times: its memory was corrupt\n",
                     "learned and forgotten",
                     result->learned.forgotten);
    }
}

/// Prints the results of a run with a target.
static void print_target(const sim_summary_t *summary)
{
    (void)printf("%-26s%s, %s: %s, %.0f ticks a second in lock-step\n",
                 "target",
                 summary->target,
                 summary->q31 ? "q31" : "f32",
                 summary->lock_step.different_ticks == 0 ? "the same bits as the host" : "differs from the host",
                 summary->lock_step.ticks_per_s);
    if (summary->lock_step.cycles_most > 0u)
    {
        (void)printf("%-26s%" PRIu32 " to %" PRIu32 ", %" PRIu32 " on average\n",
                     "cycles of a tick",
                     summary->lock_step.cycles_least,
                     summary->lock_step.cycles_most,
                     summary->lock_step.cycles_mean);
    }
}

/// Prints the differences of a run in both arithmetics.
static void print_difference(const sim_summary_t *summary)
{
    (void)printf("%-26s%.6f N\n", "RMS error in Q31", summary->result_q31.rms_error_n);
    print_activity(" in Q31", &summary->result_q31.activity);
    (void)printf("%-26su %.3g N, F %.3g N (RMS %.3g, %.3g)\n",
                 "largest Q31 - f32",
                 summary->difference.max_u_n,
                 summary->difference.max_force_n,
                 summary->difference.rms_u_n,
                 summary->difference.rms_force_n);
}

/// Prints the files of --out.
static void print_written(const sim_summary_t *summary, const char *folder)
{
    (void)printf("%-26s%s/trace.csv, ", "written", folder);
    if (summary->both)
    {
        (void)printf("%s/trace_q31.csv, ", folder);
    }
    if (summary->result.learns)
    {
        (void)printf("%s/learned.yaml, ", folder);
    }
    (void)printf("%s/scenario.yaml, %s/summary.json\n", folder, folder);
}

static void print_table(const sim_summary_t *summary, const options_t *options)
{
    (void)printf("%-26s%.6f N\n", "RMS error, r - F", summary->result.rms_error_n);
    (void)printf("%-26s%.6f N\n", "largest error, r - F", summary->result.max_error_n);
    (void)printf("%-26s%.6f N\n", "RMS measured error, r - y", summary->result.rms_measured_error_n);
    print_activity("", &summary->result.activity);
    print_learned(&summary->result, summary->ticks);
    (void)printf("%-26s%" PRIu64 " (limited %" PRIu64 ", bad inputs %" PRIu64 ")\n",
                 "ticks",
                 summary->ticks,
                 summary->result.limited_ticks,
                 summary->result.bad_inputs);
    if (summary->result.bad_inputs > 0)
    {
        (void)printf("%-26s%s\n",
                     "bad inputs",
                     "r or y beyond limits.input_max_N, where e counts as 0: are forces in N?");
    }
    (void)printf("%-26s%g s in %.3f s, %.0f times real time\n",
                 "simulated",
                 summary->simulated_s,
                 summary->wall_s,
                 summary->real_time_factor);
    if (summary->result.guard != NULL)
    {
        (void)printf("%-26s%s\n", "guard has faded for", summary->result.guard);
    }
    if (summary->target != NULL)
    {
        print_target(summary);
    }
    if (summary->both)
    {
        print_difference(summary);
    }
    if (options->folder != NULL && options->temporary == NULL)
    {
        print_written(summary, options->folder);
    }
}

/// Called last, so that the files are there to inspect a difference.
static bool is_identical(const sim_summary_t *summary, common_error_t *error)
{
    return summary->target == NULL || summary->lock_step.different_ticks == 0 ||
           common_error_set(error, "%s", summary->lock_step.difference);
}

// --- the picture ---------------------------------------------------------------------------------------------------

/// Removes the temporary folder of a run that has a picture or has failed.
static void remove_folder(const options_t *options)
{
    for (int i = 0; options->temporary != NULL && i < FILES; i++)
    {
        char *path = common_text_format("%s/%s", options->temporary, file_names[i]);
        (void)(path != NULL && unlink(path));
        free(path);
    }
    (void)(options->temporary != NULL && rmdir(options->temporary));
}

static bool draw(const options_t *options, common_error_t *error)
{
    const char *slash = strrchr(options->choice.name, '/');
    const char *name  = slash != NULL ? slash + 1 : options->choice.name;
    return sim_picture_of(options->folder,
                          options->temporary != NULL ? name : NULL,
                          options->plot,
                          options->whole_plot,
                          error);
}

static bool simulate_and_report(const common_scenario_t *scenario, options_t *options, common_error_t *error)
{
    sim_summary_t summary;
    char         *json = NULL;
    if (!check_results(scenario, options, error) || !common_output_check(options->plot, error))
    {
        return false;
    }
    if (options->plot != NULL && options->folder == NULL)
    {
        options->temporary = sim_picture_folder(error);
        options->folder    = options->temporary;
    }
    if (options->plot == NULL || options->folder != NULL)
    {
        json = simulate(scenario, options, &summary, error);
    }
    if (json == NULL)
    {
        remove_folder(options);
        return false;
    }
    if (options->json)
    {
        (void)puts(json);
    }
    else
    {
        print_table(&summary, options);
    }
    free(json);
    const bool ok = common_output_flush(error) && (options->plot == NULL || draw(options, error));
    if (ok)
    {
        remove_folder(options);
    }
    return ok && is_identical(&summary, error) && sim_run_was_controlled(scenario, &summary, error);
}

/// Refuses options that the others make useless.
static int check_options(const options_t *options)
{
    const bool has_trace = options->folder != NULL || options->plot != NULL;
    if (options->whole_plot && options->plot == NULL)
    {
        return sim_usage("--all needs --plot");
    }
    if (options->trace.every > 0u && !has_trace)
    {
        return sim_usage("--decimate needs --out or --plot");
    }
    return !options->trace.is_chosen || has_trace ? sim_scenario_check_arithmetic(&options->choice, 1)
                                                  : sim_usage("--columns needs --out or --plot");
}

static int run(int count, char **arguments)
{
    options_t options = {.count = count, .arguments = arguments};
    int       status  = sim_options_parse(&sim_command_run, count, arguments, &options, &options.choice.name);
    if (status == 0)
    {
        status = check_options(&options);
    }
    if (status == 0)
    {
        common_error_t     error    = {""};
        common_scenario_t *scenario = sim_scenario_open(&options.choice, &error);
        options.run.both            = scenario != NULL && sim_scenario_config(scenario)->arithmetic == SIM_BOTH;
        if (options.run.both && options.run.target != NULL)
        {
            status = sim_usage("--target takes --arith f32 or q31, not both");
        }
        else if (scenario == NULL || !simulate_and_report(scenario, &options, &error))
        {
            status = sim_failure(error.text);
        }
        common_scenario_destroy(scenario);
    }
    sim_scenario_choice_free(&options.choice);
    free(options.temporary);
    return status;
}

const sim_command_t sim_command_run = {.name     = "run",
                                       .argument = "SCENARIO.yaml",
                                       .noun     = "scenario",
                                       .text = "Plays a scenario: a path, or the name of one in the scenarios folder.",
                                       .options = known,
                                       .run     = run,
                                       .take    = take};
