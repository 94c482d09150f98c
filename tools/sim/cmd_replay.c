// Runs a recorded log through the compensator, to show its estimate on the user's own rig.

#include "log/verdict.h"
#include "loop/loop_config.h"
#include "scenario/activity.h"
#include "scenario/check.h"
#include "scenario/loop.h"
#include "sim/commands.h"
#include "sim/log_options.h"
#include "sim/picture.h"
#include "sim/progress.h"
#include "sim/scenario_choice.h"
#include "sim/trace.h"
#include "support/file.h"
#include "support/number.h"
#include "support/output_file.h"
#include "support/text.h"
#include "tribo/friction_f32.h"
#include "tribo/friction_q31.h"
#include "tribo_arithmetic.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct
{
    sim_log_arguments_t   logs;
    sim_scenario_choice_t choice; ///< replay uses only its --set
    const char           *params; ///< null: the paper's
    const char           *out;    ///< null: standard output
    const char           *plot;   ///< null: none
    bool                  measured;
    bool                  f32, q31;       ///< what to run, one or both
    bool                  has_full_scale; ///< given
    double                full_scale_n;
} options_t;

/// The compensator in both arithmetics; Q31 params only on demand.
typedef struct
{
    const options_t               *options;
    double                         sample_time_s;
    common_loop_config_t           loop; ///< holds the breakaway table that the params point to
    tribo_compensator_f32_params_t f32;
    tribo_compensator_f32_state_t  state_f32;
    tribo_compensator_q31_params_t q31;
    tribo_compensator_q31_state_t  state_q31;
    tribo_breakaway_point_q31_t    table[TRIBO_BREAKAWAY_POINTS_MAX];
    uint64_t                       beyond_full_scale;    ///< rows
    uint32_t                       bad_inputs;           ///< of all segments
    double                         max_force_n, max_f_n; ///< largest differences
    sim_replayed_t                 replayed;             ///< by row, for the verdict
    sim_activity_t                 activity, activity_q31;
} replay_t;

static int check_result(const options_t *options, const char *option, const char *result)
{
    if (result != NULL && options->params != NULL && common_file_is_same(result, options->params))
    {
        return sim_usage("replay: --%s %s is the same file as --params %s", option, result, options->params);
    }
    return sim_log_check(&options->logs, "replay", option, result);
}

/// A recording is irreplaceable: no result may overwrite it or the params.
static int check_results(const options_t *options)
{
    if (options->out != NULL && options->plot != NULL && strcmp(options->out, options->plot) == 0)
    {
        return sim_usage("replay: --out and --plot are the same file %s", options->out);
    }
    if (options->has_full_scale && !options->q31)
    {
        return sim_usage("--full-scale needs --arith q31 or both");
    }
    const int status = check_result(options, "out", options->out);
    return status != 0 ? status : check_result(options, "plot", options->plot);
}

enum
{
    OPTION_PARAMS = SIM_OPTION_FIRST,
    OPTION_SET,
    OPTION_FORCE,
    OPTION_OUT,
    OPTION_PLOT,
    OPTION_ARITH,
    OPTION_FULL_SCALE
};

// clang-format off: one row an option
static const struct argp_option known[] = {
    {.name = "params", .key = OPTION_PARAMS, .arg = "FILE.yaml", .doc = "keys of a scenario's `compensator`; the paper's values if left out"},
    {.name = "set", .key = OPTION_SET, .arg = "KEY=VALUE", .doc = "sets one of these keys, e.g. compensator.friction.k_min=8"},
    {.name = "force", .key = OPTION_FORCE, .arg = "own|measured", .doc = "takes F from the compensator's own arm model (if left out), or from the log"},
    {.name = "out", .key = OPTION_OUT, .arg = "OUT.csv", .doc = "the file to write; standard output if left out"},
    {.name = "plot", .key = OPTION_PLOT, .arg = "FILE.png|svg|html", .doc = "draws the result (see `plot`; needs Python and matplotlib)"},
    {.name = "arith", .key = OPTION_ARITH, .arg = "f32|q31|both", .doc = "f32 if left out; both writes Q31's columns after f32's, and their largest differences"},
    {.name = "full-scale", .key = OPTION_FULL_SCALE, .arg = "N", .doc = "the force of 2^31 in Q31; 2 N if left out"},
    SIM_LOG_OPTIONS,
    {.name = NULL}};
// clang-format on

static bool starts_with(const char *text, const char *start)
{
    return strncmp(text, start, strlen(start)) == 0;
}

static int take_set(options_t *options, const char *assignment)
{
    static const char *const without[] = {"compensator.method=",
                                          "compensator.gain=",
                                          "compensator.guard.",
                                          "compensator.feedforward.",
                                          "compensator.sensor"};
    if (!starts_with(assignment, "compensator."))
    {
        return sim_usage("replay: --set %s: replay reads only keys of compensator", assignment);
    }
    for (size_t i = 0; i < sizeof without / sizeof without[0]; i++)
    {
        if (starts_with(assignment, without[i]))
        {
            return sim_usage("replay: --set %s: replay judges the friction model, and this key is not part of it",
                             assignment);
        }
    }
    return sim_scenario_take_set(&options->choice, assignment);
}

static int take(void *context, int key, const char *value)
{
    options_t *options = context;
    int        word    = 0;
    switch (key)
    {
    case OPTION_PARAMS:
        options->params = value;
        return 0;
    case OPTION_SET:
        return take_set(options, value);
    case OPTION_FORCE:
        word              = sim_option_word(&sim_command_replay, key, value);
        options->measured = word == 1;
        break;
    case OPTION_OUT:
        options->out = value;
        return 0;
    case OPTION_PLOT:
        options->plot = value;
        return sim_picture_has_ending(value)
                   ? 0
                   : sim_usage("--plot %s: a name that ends in .png, .svg or .html is expected", value);
    case OPTION_ARITH:
        word         = sim_option_word(&sim_command_replay, key, value);
        options->f32 = word != 1;
        options->q31 = word != 0;
        break;
    case OPTION_FULL_SCALE:
        options->has_full_scale = true;
        return common_number_parse(value, &options->full_scale_n) == NULL
                   ? 0
                   : sim_usage("--full-scale %s: a number of N is expected", value);
    default:
        return sim_log_take(&options->logs, key, value);
    }
    return word >= 0 ? 0 : SIM_EXIT_USAGE;
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

/// A Q31 step's signals in newtons, to float's seven digits.
static tribo_compensator_f32_signals_t signals_from_q31(const tribo_compensator_q31_signals_t *signals,
                                                        double                                 full_scale_n,
                                                        double                                 sample_time_s)
{
    const tribo_friction_q31_signals_t *friction = &signals->friction;
    return (tribo_compensator_f32_signals_t){
        .force_n  = (float)tribo_n_of_q31(signals->force, full_scale_n),
        .friction = {.n_n       = (float)tribo_n_of_q31(friction->n, full_scale_n),
                     .L_n       = (float)tribo_n_of_q31(friction->L, full_scale_n),
                     .v_n_per_s = (float)(tribo_n_of_q31(friction->rise, full_scale_n) / sample_time_s),
                     .f_n       = (float)tribo_n_of_q31(friction->f, full_scale_n),
                     .relays    = friction->relays}};
}

static tribo_compensator_f32_signals_t step_q31(replay_t *replay, double u_n, double measured_n)
{
    const double                    full_scale_n = replay->options->full_scale_n;
    const int32_t                   u            = tribo_q31_of_n(u_n, full_scale_n);
    tribo_compensator_q31_signals_t signals;
    replay->beyond_full_scale += fabs(u_n) > full_scale_n || fabs(measured_n) > full_scale_n;
    if (replay->options->measured)
    {
        signals.force = tribo_q31_of_n(measured_n, full_scale_n);
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

/// Keeps the verdict's inputs, from the first arithmetic.
static void keep(replay_t *replay, size_t row, const tribo_compensator_f32_signals_t *signals, double measured_n)
{
    const tribo_friction_f32_signals_t *friction = &signals->friction;
    // If F comes from the arm's model, n is the model's; the verdict needs the log's n.
    const float n           = friction->n_n + (signals->force_n - (float)measured_n);
    replay->replayed.n[row] = n;
    replay->replayed.L[row] = friction->L_n;
    replay->replayed.f[row] = friction->f_n;
    replay->replayed.q[row] = (friction->relays & TRIBO_RELAY_Q) != 0u;
}

static void replay_row(replay_t *replay, const sim_log_t *log, size_t segment, size_t row, FILE *file)
{
    const bool                      has_force = log->values[SIM_LOG_F] != NULL;
    const double                    u         = log->values[SIM_LOG_U][row];
    const double                    F         = has_force ? log->values[SIM_LOG_F][row] : 0.0;
    tribo_compensator_f32_signals_t f32       = {.force_n = 0.0f};
    tribo_compensator_f32_signals_t q31       = {.force_n = 0.0f};
    // 15 digits reproduce a time stamp as written, whatever its origin.
    (void)fprintf(file, "%.15g,%.9g", log->values[SIM_LOG_T][row], u);
    if (replay->options->f32)
    {
        f32 = step_f32(replay, u, F);
        sim_trace_write_compensator(file, &f32);
    }
    if (replay->options->q31)
    {
        q31 = step_q31(replay, u, replay->options->measured ? F : 0.0);
        sim_trace_write_compensator(file, &q31);
    }
    if (replay->options->f32 && replay->options->q31)
    {
        replay->max_force_n = fmax(replay->max_force_n, fabs((double)q31.force_n - (double)f32.force_n));
        replay->max_f_n     = fmax(replay->max_f_n, fabs((double)q31.friction.f_n - (double)f32.friction.f_n));
    }
    sim_activity_add(&replay->activity, 0.0, u, (f32.friction.relays & TRIBO_RELAY_Q) != 0u);
    sim_activity_add(&replay->activity_q31, 0.0, u, (q31.friction.relays & TRIBO_RELAY_Q) != 0u);
    const tribo_compensator_f32_signals_t *shown = replay->options->f32 ? &f32 : &q31;
    keep(replay, row, shown, has_force ? F : (double)shown->force_n);
    if (has_force)
    {
        (void)fprintf(file, ",%.9g,%.9g", F, (double)replay->replayed.n[row] - (double)shown->friction.f_n);
    }
    if (log->values[SIM_LOG_R] != NULL)
    {
        (void)fprintf(file, ",%.9g", log->values[SIM_LOG_R][row]);
    }
    if (log->segments > 1)
    {
        (void)fprintf(file, ",%zu", segment);
    }
    (void)fputs("\n", file);
}

static const char q31_columns[] = ",F_hat_q31_N,n_q31_N,L_q31_N,v_q31_N_per_s,Q1_q31,Q2_q31,Q_q31,f_hat_q31_N";

static void reset(replay_t *replay)
{
    tribo_compensator_f32_reset(&replay->state_f32);
    tribo_compensator_q31_reset(&replay->state_q31);
}

static void step_through(replay_t *replay, const sim_log_t *log, FILE *file)
{
    sim_progress_t progress   = {.calls = 0};
    const bool     both       = replay->options->f32 && replay->options->q31;
    uint32_t       bad_inputs = 0;
    replay->activity          = (sim_activity_t){.move_n = SIM_ACTIVITY_MOVE * replay->options->full_scale_n};
    replay->activity_q31      = replay->activity;
    (void)fprintf(file,
                  "t_s,u_N%s%s%s%s%s\n",
                  SIM_TRACE_COMPENSATOR,
                  both ? q31_columns : "",
                  log->values[SIM_LOG_F] != NULL ? ",F_N,residual_N" : "",
                  log->values[SIM_LOG_R] != NULL ? ",r_N" : "",
                  log->segments > 1 ? ",segment" : "");
    for (size_t s = 0; s < log->segments; s++)
    {
        reset(replay);
        sim_activity_break(&replay->activity);
        sim_activity_break(&replay->activity_q31);
        for (size_t i = log->starts[s]; i < log->starts[s + 1] && !ferror(file); i++)
        {
            replay_row(replay, log, s, i, file);
            sim_progress_update(&progress, (double)i / (double)log->rows);
        }
        bad_inputs += replay->state_f32.friction.bad_inputs;
    }
    replay->bad_inputs = bad_inputs;
    sim_progress_end(&progress);
}

static void warn(const options_t *options, uint64_t rows, const char *of_what)
{
    if (rows > 0)
    {
        (void)fprintf(stderr,
                      "tribo-sim: %s: warning: %u rows hold forces %s\n",
                      options->logs.paths[0],
                      (unsigned)rows,
                      of_what);
    }
}

/// The params' model for the verdict: always float32, whatever --arith and --force say.
static void play(void *context, const sim_log_t *log, size_t rows, const sim_path_t *path, double *force_n)
{
    const replay_t                *replay = context;
    tribo_compensator_f32_params_t params = replay->f32;
    tribo_breakaway_point_f32_t    table[TRIBO_BREAKAWAY_POINTS_MAX];
    for (size_t i = 0; i < 2; i++)
    {
        params.friction.law[i].offset_n *= (float)path->ratio;
        params.friction.law[i].slope *= (float)path->ratio;
    }
    for (size_t i = 0; i < params.friction.table_length; i++)
    {
        table[i] = replay->f32.friction.table[i];
        table[i].positive_n *= (float)path->ratio;
        table[i].negative_n *= (float)path->ratio;
    }
    params.friction.table = params.friction.table_length > 0 ? table : NULL;
    tribo_compensator_f32_state_t state;
    for (size_t s = 0, k = 0; s < log->segments && k < rows; s++)
    {
        tribo_compensator_f32_reset(&state);
        state.arm.force_n = (float)log->values[SIM_LOG_F][k];
        for (; k < log->starts[s + 1] && k < rows; k++)
        {
            tribo_compensator_f32_signals_t signals;
            const double                    u = (log->values[SIM_LOG_U][k] - path->bias_n) / (1.0 + path->scale_error);
            (void)tribo_compensator_f32_step(&params, &state, (float)u, &signals);
            force_n[k] = (double)signals.force_n;
        }
    }
}

/// Prints the activity of the log's command and of the compensator.
static void print_activity(const replay_t *replay)
{
    const sim_activity_t *activity = &replay->activity;
    (void)printf("activity  u varies %.4g N, chatter in %" PRIu64 " of %" PRIu64 " ticks; Q switches",
                 activity->u_variation_n,
                 activity->chatter_ticks,
                 activity->ticks);
    if (replay->options->f32)
    {
        (void)printf(" %" PRIu64 " times", activity->q_switches);
    }
    if (replay->options->q31)
    {
        (void)printf("%s %" PRIu64 " times in Q31", replay->options->f32 ? "," : "", replay->activity_q31.q_switches);
    }
    (void)puts("");
}

/// Writes the table, then the verdict: next to the table if that is a file, else on stderr.
static bool write_results(replay_t *replay, const char *out, const sim_log_t *log, common_error_t *error)
{
    const options_t     *options = replay->options;
    common_output_file_t file    = {.stream = NULL};
    sim_verdict_t        verdict;
    if (!common_output_open(&file, out, error))
    {
        return false;
    }
    step_through(replay, log, file.stream);
    const sim_model_t model = {.play = play, .context = replay};
    if (!common_output_commit(&file, 1, error) || !sim_verdict_make(&verdict, log, &replay->replayed, &model, error))
    {
        return false;
    }
    sim_log_report(log, options->logs.paths[0]);
    warn(options, replay->bad_inputs, "too large for the compensator");
    warn(options, replay->beyond_full_scale, "beyond full scale");
    if (options->f32 && options->q31)
    {
        (void)fprintf(stderr, "largest Q31 - f32: F_hat %.3g N, f_hat %.3g N\n", replay->max_force_n, replay->max_f_n);
    }
    if (out == NULL)
    {
        return true; // the table is for the next program; the verdict comes with --out
    }
    sim_verdict_write(&verdict, log, stdout);
    print_activity(replay);
    return common_output_flush(error);
}

/// Writes the results and their picture. With a picture alone the table is only kept until it is drawn.
static bool draw_results(replay_t *replay, const sim_log_t *log, common_error_t *error)
{
    const options_t *options = replay->options;
    const char      *slash   = strrchr(options->logs.paths[0], '/');
    const char      *name    = slash != NULL ? slash + 1 : options->logs.paths[0];
    char            *folder  = options->out == NULL ? sim_picture_folder(error) : NULL;
    char            *table   = folder != NULL ? common_text_format("%s/replay.csv", folder) : NULL;
    const char      *out     = options->out != NULL ? options->out : table;
    const bool       ok      = out != NULL && write_results(replay, out, log, error);
    const bool       drawn   = ok && sim_picture_of(out, name, options->plot, true, error);
    if (folder != NULL && (drawn || !ok))
    {
        (void)(table != NULL && unlink(table));
        (void)rmdir(folder);
    }
    free(table);
    free(folder);
    return drawn || common_error_set(error, "out of memory"); // unless an error is set already
}

static bool replay_log(replay_t *replay, const sim_log_t *log, common_error_t *error)
{
    sim_replayed_t *replayed = &replay->replayed;
    replayed->n              = malloc(log->rows * sizeof *replayed->n);
    replayed->L              = malloc(log->rows * sizeof *replayed->L);
    replayed->f              = malloc(log->rows * sizeof *replayed->f);
    replayed->q              = malloc(log->rows);
    replayed->is_measured    = replay->options->measured;
    const bool  is_room      = replayed->n != NULL && replayed->L != NULL && replayed->f != NULL && replayed->q != NULL;
    const char *out          = replay->options->out;
    bool        ok           = is_room || common_error_set(error, "out of memory");
    ok                       = ok &&
         (replay->options->plot != NULL ? draw_results(replay, log, error) : write_results(replay, out, log, error));
    free(replayed->n);
    free(replayed->L);
    free(replayed->f);
    free(replayed->q);
    return ok;
}

/// The compensator's params for the log's sample time.
static bool make_params(replay_t *replay, common_scenario_t *scenario, common_error_t *error)
{
    const options_t            *options = replay->options;
    common_loop_config_t *const loop    = &replay->loop;
    if (options->params != NULL && !common_scenario_load_compensator(scenario, options->params, error))
    {
        return false;
    }
    for (int i = 0; i < options->choice.set_count; i++)
    {
        if (!common_scenario_set(scenario, options->choice.sets[i], error))
        {
            return false;
        }
    }
    // The only method with a friction model that a log can test.
    if (!common_scenario_set(scenario, "compensator.method=paper", error) || !common_check_compensator(scenario, error))
    {
        return false;
    }
    common_loop_config_fill(loop, common_scenario_loop(scenario));
    const float    h      = (float)replay->sample_time_s;
    tribo_status_t status = tribo_compensator_f32_init(&replay->f32, &loop->parts.config.compensator, h);
    if (status == TRIBO_OK && options->q31)
    {
        status = tribo_compensator_q31_init(&replay->q31,
                                            replay->table,
                                            &loop->parts.config.compensator,
                                            h,
                                            (float)options->full_scale_n);
    }
    if (status == TRIBO_ERR_SAMPLE_TIME)
    {
        return common_error_set(error,
                                "%s: its sample time is %.6g s; %s",
                                options->logs.paths[0],
                                replay->sample_time_s,
                                tribo_status_text(status));
    }
    if (status == TRIBO_ERR_FULL_SCALE)
    {
        return common_error_set(error, "--full-scale %g: %s", options->full_scale_n, tribo_status_text(status));
    }
    return common_check_status(scenario, status, error);
}

static bool replay_with(const options_t   *options,
                        common_scenario_t *scenario,
                        const sim_log_t   *log,
                        common_error_t    *error)
{
    replay_t replay = {.options = options, .sample_time_s = log->sample_time_s};
    return make_params(&replay, scenario, error) && replay_log(&replay, log, error);
}

static bool replay(options_t *options, common_error_t *error)
{
    sim_log_t         log;
    sim_log_column_t *force = &options->logs.options.columns[SIM_LOG_F];
    if (force->option == NULL && (options->measured || options->plot != NULL))
    {
        force->option = options->measured ? "force" : "plot";
        force->text   = options->measured ? "measured" : options->plot;
    }
    if (!common_output_check(options->out, error) || !common_output_check(options->plot, error) ||
        !sim_log_read(&log, options->logs.paths, options->logs.count, &options->logs.options, error))
    {
        return false;
    }
    common_scenario_t *scenario = sim_scenario_create();
    const bool         ok =
        (scenario != NULL) ? replay_with(options, scenario, &log, error) : common_error_set(error, "out of memory");
    common_scenario_destroy(scenario);
    sim_log_free(&log);
    return ok;
}

static int run(int count, char **arguments)
{
    options_t      options = {.f32 = true, .full_scale_n = 2.0};
    common_error_t error   = {""};
    int            status  = sim_options_parse(&sim_command_replay, count, arguments, &options, NULL);
    if (status == 0)
    {
        status = check_results(&options);
    }
    if (status == 0 && !replay(&options, &error))
    {
        status = sim_failure(error.text);
    }
    sim_scenario_choice_free(&options.choice);
    return status;
}

const sim_command_t sim_command_replay = {
    .name     = "replay",
    .argument = "LOG.csv...",
    .noun     = "log",
    .is_many  = true,
    .text =
        "Runs recorded logs (time, command and maybe force) through the friction compensator, and judges its params.",
    .options = known,
    .run     = run,
    .take    = take};
