// The program opens everything and then becomes two processes (supervisor.h). The process with the loop has up to three threads:
// this one makes the ticks, recorder.h writes the log, background.h serves the bus.

#include "program.h"

#include "background.h"
#include "board.h"
#include "messages.h"
#include "params_file.h"
#include "params_name.h"
#include "recorder.h"
#include "signals.h"
#include "supervisor.h"

#include "app/registers.h"
#include "app/selftest.h"
#include "loop/loop_check.h"
#include "loop/loop_config.h"
#include "loop/reference.h"
#include "support/data_path.h"
#include "support/file.h"
#include "support/number.h"
#include "support/options.h"
#include "support/output_file.h"
#include "tribo/status.h"

#include <argp.h>
#include <errno.h>
#include <fcntl.h>
#include <float.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define SETS_MAX    32u
#define NS_PER_US   1000
#define NS_PER_MS   1000000
#define SLEEP_NS    5000000
#define TRACE_WORDS 65536u ///< 16 s of four signals at 1 kHz

enum
{
    EXIT_OK    = 0,
    EXIT_SETUP = 1, ///< configuration, devices or log are wrong
    EXIT_USAGE = 2,
    EXIT_FAULT = 3 ///< a fault stopped the drive
};

typedef struct
{
    const char *name; ///< of the program
    const char *config, *log, *ticks;
    const char *sets[SETS_MAX];
    unsigned    set_count;
    bool        check, keys;
    double      duration_s; ///< 0: the run ends at a signal
    enum
    {
        REFERENCE_SCENARIO, ///< --reference is missing: the scenario's, or none with a bus
        REFERENCE_CONSTANT,
        REFERENCE_LINES
    } reference;
    bool        has_reference; ///< the command line has --reference
    double      constant_n;
    const char *shape; ///< shape or file that replaces the scenario's reference; null: none
} options_t;

// --- the command line ----------------------------------------------------------------------------------------------

enum
{
    OPTION_CHECK     = 'c',
    OPTION_DURATION  = 'd',
    OPTION_KEYS      = 'k',
    OPTION_LOG       = 'l',
    OPTION_REFERENCE = 'r',
    OPTION_SET       = 's',
    OPTION_TICKS     = 't',
    OPTION_USAGE     = 256,
    OPTION_VERSION   = 'V'
};

static const struct argp_option known[] = {
    {.name = "check",
     .key  = OPTION_CHECK,
     .doc  = "reads the configuration and opens everything, with outputs at 0, and ends"},
    {.name = "duration",
     .key  = OPTION_DURATION,
     .arg  = "S",
     .doc  = "ends after this time in s; without it, at a signal, e.g. SIGINT or SIGTERM"},
    {.name = "keys", .key = OPTION_KEYS, .doc = "prints the configuration's keys as a table in Markdown and ends"},
    {.name = "log", .key = OPTION_LOG, .arg = "FILE.csv", .doc = "writes a row a tick, which tribo-sim replay reads"},
    {.name = "reference",
     .key  = OPTION_REFERENCE,
     .arg  = "N|SHAPE|FILE.csv|-",
     .doc =
         "a constant in N, a shape of scenarios (triangle, sine ...), a file with t_s and r_N, or lines with a "
         "number in N on standard input; without this option the reference of the bus or, without a bus, that of the "
         "scenario"},
    {.name = "set",
     .key  = OPTION_SET,
     .arg  = "KEY=VALUE",
     .doc  = "changes a key of the scenario, e.g. reference.kind=sine"},
    {.name = "ticks",
     .key  = OPTION_TICKS,
     .arg  = "IN,OUT",
     .doc  = "for tests: a tick for each byte of the file IN, and a byte to OUT after it, in place of the clock"},
    {.name = "help", .key = '?', .doc = "prints this help"},
    {.name = "usage", .key = OPTION_USAGE, .doc = "prints the options in short"},
    {.name = "version", .key = OPTION_VERSION, .doc = "prints the version of this program"},
    {.name = NULL}};

/// Returns true for text that was meant as a number: a shape's name begins with a letter, and a file's name ends with .csv.
static bool is_meant_as_number(const char *value)
{
    const char *dot = strrchr(value, '.');
    return strchr("+-.0123456789", value[0]) != NULL && (dot == NULL || strcmp(dot, ".csv") != 0);
}

static void take_reference(options_t *options, const char *value, const struct argp_state *state)
{
    options->shape         = NULL;
    options->reference     = REFERENCE_LINES;
    options->has_reference = true;
    if (strcmp(value, "-") != 0)
    {
        const char *complaint = common_number_parse(value, &options->constant_n);
        const bool  is_number = complaint == NULL;
        if (common_number_is_below(value, (double)PARAMS_LEAST_N))
        {
            argp_error(state,
                       "--reference %s: too small to be meant: 0, or at least %.0e N in size",
                       value,
                       (double)PARAMS_LEAST_N);
        }
        if (!is_number && is_meant_as_number(value))
        {
            argp_error(state, "--reference %s: %s", value, complaint);
        }
        options->reference = is_number ? REFERENCE_CONSTANT : REFERENCE_SCENARIO;
        options->shape     = is_number ? NULL : value;
    }
}

/// Writes out standard output. Returns the exit status: the given one, or EXIT_SETUP if output is lost.
static int finish(int status)
{
    common_error_t error = {""};
    if (status != EXIT_OK || common_output_flush(&error))
    {
        return status;
    }
    (void)fprintf(stderr, "%s: %s\n", program_invocation_short_name, error.text);
    return EXIT_SETUP;
}

static error_t take(int key, char *value, struct argp_state *state)
{
    common_error_t error   = {""};
    options_t     *options = state->input;
    if (!common_options_add(known, key, value, &error))
    {
        argp_error(state, "%s", error.text);
    }
    switch (key)
    {
    case '?':
        argp_state_help(state, stdout, ARGP_HELP_STD_HELP & ~ARGP_HELP_EXIT_OK);
        exit(finish(EXIT_OK));
    case OPTION_USAGE:
        argp_state_help(state, stdout, ARGP_HELP_USAGE);
        exit(finish(EXIT_OK));
    case OPTION_VERSION:
        (void)printf("%s " TRIBO_VERSION_STRING "\n", options->name);
        exit(finish(EXIT_OK));
    case OPTION_CHECK:
        options->check = true;
        return 0;
    case OPTION_KEYS:
        options->keys = true;
        return 0;
    case OPTION_DURATION:
        if (common_number_parse(value, &options->duration_s) != NULL ||
            !(options->duration_s >= 1e-3 && options->duration_s <= 1e6))
        {
            argp_error(state, "--duration %s: a time of 0.001 to 1e6 s is expected", value);
        }
        return 0;
    case OPTION_LOG:
        options->log = value;
        return 0;
    case OPTION_TICKS:
        options->ticks = value;
        return strchr(value, ',') != NULL ? 0
                                          : (argp_error(state, "--ticks %s: two files are expected, IN,OUT", value), 0);
    case OPTION_REFERENCE:
        take_reference(options, value, state);
        return 0;
    case OPTION_SET:
        if (options->set_count == SETS_MAX)
        {
            argp_error(state, "more than %u --set", SETS_MAX);
        }
        options->sets[options->set_count++] = value;
        return 0;
    case ARGP_KEY_ARG:
        if (options->config != NULL)
        {
            argp_error(state, "one configuration is expected, not %s as well", value);
        }
        options->config = value;
        return 0;
    case ARGP_KEY_END:
        if (options->config == NULL && !options->keys)
        {
            argp_error(state, "a configuration is expected");
        }
        if (options->keys && state->argc > 2)
        {
            argp_error(state, "--keys goes with nothing else");
        }
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

// --- the ticks -----------------------------------------------------------------------------------------------------

typedef struct
{
    const options_t   *options;
    const desk_t      *desk; ///< null: the drive is on devices and lines
    const rig_t       *rig;
    common_scenario_t *scenario;
    board_t            board;
    params_set_t       defaults; ///< from the configuration and its scenario
    params_ceiling_t   ceilings[48];
    uint32_t           ceiling_count;
    params_file_t      store;
    registers_t        registers;
    uint32_t           ring[TRACE_WORDS];
    gate_t             gate;
    bus_t             *bus; ///< null: there is no bus
    background_t       background;
    common_reference_t reference;
    recorder_t        *recorder;
    int                ticks_in, ticks_out; ///< -1: the clock makes the ticks

    char        line[64]; ///< the present line of standard input, as far as it has come
    size_t      line_length;
    bool        line_end; ///< standard input has ended
    histogram_t wake, step;
    uint64_t    overruns, late;
} program_t;

/// Returns true if the loop accepts references up to `peak_n`. It would run with e = 0 at larger ones.
static bool check_reference(const program_t *program, const char *name, double peak_n, common_error_t *error)
{
    float most_n;
    memcpy(&most_n, &program->registers.active->set.loop[PARAMS_INPUT_MAX - PARAMS_LOOP_AT], sizeof most_n);
    return peak_n <= (double)most_n ||
           common_error_set(error,
                            "%s: %.9g N: must be within -%.9g to %.9g N, the range of limits.input_max_N",
                            name,
                            peak_n,
                            (double)most_n,
                            (double)most_n);
}

/// Takes a line with a number in N. A line that is not a number, or beyond the loop's range, ends the run.
static bool take_line(program_t *program, common_error_t *error)
{
    double value;
    program->line[program->line_length] = '\0';
    program->line_length                = 0;
    const char *complaint               = common_number_parse(program->line, &value);
    if (complaint != NULL)
    {
        return common_error_set(error, "standard input: '%s' %s", program->line, complaint);
    }
    if (!check_reference(program, "standard input", fabs(value), error))
    {
        return false;
    }
    drive_reference(&program->registers.drive, (float)value);
    return true;
}

/// Takes everything that has come on standard input since the last tick, without waiting.
static bool read_lines(program_t *program, common_error_t *error)
{
    struct pollfd input = {.fd = STDIN_FILENO, .events = POLLIN};
    char          bytes[64];
    if (program->line_end || poll(&input, 1, 0) <= 0)
    {
        return true;
    }
    const ssize_t count = read(STDIN_FILENO, bytes, sizeof bytes);
    program->line_end   = count == 0;
    if (count < 0 && errno != EINTR && errno != EAGAIN)
    {
        return common_error_set(error, "standard input: cannot be read: %s", strerror(errno));
    }
    for (ssize_t i = 0; i < count; i++)
    {
        if (bytes[i] == '\n' ? !take_line(program, error) : program->line_length + 1u >= sizeof program->line)
        {
            return common_error_set(error, "standard input: a line is too long");
        }
        if (bytes[i] != '\n')
        {
            program->line[program->line_length++] = bytes[i];
        }
    }
    if (program->line_end && program->line_length > 0u) // its sender may have ended within a number
    {
        return common_error_set(error,
                                "standard input: '%.*s' is not a whole line: it ends without a newline",
                                (int)program->line_length,
                                program->line);
    }
    return true;
}

static bool renew_reference(program_t *program, double t_s, common_error_t *error)
{
    drive_t *drive = &program->registers.drive;
    if (program->bus != NULL && !program->options->has_reference)
    {
        return true; // the bus sets the reference
    }
    switch (program->options->reference)
    {
    case REFERENCE_SCENARIO:
        drive_set_reference(drive, (float)common_reference_at(&program->reference, t_s));
        return true;
    case REFERENCE_CONSTANT:
        drive_set_reference(drive, (float)program->options->constant_n);
        return true;
    default:
        return read_lines(program, error);
    }
}

/// Waits until `due_ns`, in several parts, because a signal may come just before a wait begins.
static void sleep_until(int64_t due_ns)
{
    for (int64_t now_ns = realtime_now_ns(); now_ns < due_ns && signals_latest() == 0; now_ns = realtime_now_ns())
    {
        (void)realtime_sleep_until(due_ns < now_ns + SLEEP_NS ? due_ns : now_ns + SLEEP_NS);
    }
}

/// Waits for tick `number`. Returns false if the run is to end.
static bool wait_for_tick(program_t *program, uint64_t number, int64_t *due_ns)
{
    char byte;
    *due_ns += (int64_t)program->rig->drive.period_us * NS_PER_US;
    board_begin(&program->board, number, *due_ns);
    if (program->ticks_in >= 0)
    {
        return read(program->ticks_in, &byte, 1) == 1 && signals_latest() == 0;
    }
    sleep_until(*due_ns);
    return signals_latest() == 0;
}

static void record(program_t *program, double t_s, int64_t late_ns, int64_t step_ns)
{
    const drive_t        *drive  = &program->registers.drive;
    const drive_config_t *config = board_config(&program->board);
    histogram_add(&program->wake, late_ns);
    program->overruns += step_ns > (int64_t)config->budget_us * NS_PER_US;
    program->late += late_ns > (int64_t)config->late_us * NS_PER_US;
    recorder_add(program->recorder,
                 &(recorder_row_t){.t_s     = t_s,
                                   .r_n     = drive->r,
                                   .y_n     = drive->y,
                                   .u_n     = program->registers.applied,
                                   .state   = (uint32_t)drive->state,
                                   .fault   = (uint32_t)drive->fault,
                                   .limits  = drive->limits,
                                   .late_us = (float)late_ns / NS_PER_US,
                                   .step_us = (float)step_ns / NS_PER_US});
}

/// Runs one tick. Returns false if the run is to end.
static bool tick(program_t *program, uint64_t number, int64_t due_ns, common_error_t *error)
{
    board_t      *board    = &program->board;
    const int64_t start_ns = realtime_now_ns();
    const double  t_s      = (double)number * 1e-6 * program->rig->drive.period_us;
    if (!renew_reference(program, t_s, error))
    {
        return false;
    }
    board->failed = (board->lines != NULL && !lines_set(board->lines, LINE_PROBE, true)) || board->failed;
    gate_pass(&program->gate);
    registers_tick(&program->registers);
    gate_pass(&program->gate);
    if (program->bus == NULL)
    {
        registers_run(&program->registers); // without a background, this checks the params' seal
    }
    board->failed = (board->lines != NULL && !lines_set(board->lines, LINE_PROBE, false)) || board->failed;
    board_pulse(board);
    record(program, t_s, program->ticks_in >= 0 ? 0 : start_ns - due_ns, realtime_now_ns() - start_ns);
    histogram_add(&program->step, realtime_now_ns() - start_ns);
    board_advance(board);
    if (board->failed)
    {
        return common_error_set(error, "a device or line fails: %s", strerror(errno));
    }
    const char byte = '.';
    return program->ticks_out < 0 || write(program->ticks_out, &byte, 1) == 1;
}

static bool is_over(const program_t *program, uint64_t number)
{
    const double periods  = program->options->duration_s * 1e6 / program->rig->drive.period_us;
    const bool   gives_up = program->bus == NULL && program->registers.drive.state == DRIVE_FAULT;
    return gives_up || (periods > 0.0 && (double)number >= floor(periods + 0.5));
}

static bool complain_of_supervisor(const program_t *program, common_error_t *error)
{
    return common_error_set(error,
                            SUPERVISOR_NAME " has not looked for %llu ms, stopped",
                            (unsigned long long)program->rig->heartbeat_ms);
}

/// Runs the drive from its start to its end. Returns the number of ticks.
static uint64_t run_ticks(program_t *program, heart_t *heart, common_error_t *error)
{
    uint64_t number = 0;
    int64_t  due_ns = realtime_now_ns();
    if (program->bus == NULL)
    {
        drive_start(&program->registers.drive);
    }
    while (!is_over(program, number) && wait_for_tick(program, number, &due_ns))
    {
        const bool is_watched = heart_beat(heart) || complain_of_supervisor(program, error);
        const bool ok         = is_watched && tick(program, number, due_ns, error);
        number += is_watched;
        if (!ok)
        {
            break;
        }
    }
    board_off(&program->board);
    heart_rest(heart);
    return number;
}

static int end(program_t *program, uint64_t ticks, common_error_t *error)
{
    uint64_t written = 0;
    uint64_t dropped = 0;
    drive_report(&program->registers.drive);
    drive_log(&program->registers.drive); // logs warnings that the bus has not logged
    if (program->recorder != NULL && recorder_stop(program->recorder, &written, &dropped, error))
    {
        (void)
            fprintf(stderr, "log: %llu rows, %llu dropped\n", (unsigned long long)written, (unsigned long long)dropped);
    }
    (void)fprintf(stderr,
                  "%llu ticks, %llu late, %llu overruns\n",
                  (unsigned long long)ticks,
                  (unsigned long long)program->late,
                  (unsigned long long)program->overruns);
    histogram_print(&program->wake, "wake-up", stderr);
    histogram_print(&program->step, "step", stderr);
    if (error->text[0] != '\0')
    {
        (void)fprintf(stderr, "%s: %s\n", program_invocation_short_name, error->text);
        return EXIT_SETUP;
    }
    return program->registers.drive.state == DRIVE_FAULT ? EXIT_FAULT : EXIT_OK;
}

/// Runs the process with the loop.
static int run(void *context, heart_t *heart)
{
    program_t              *program  = context;
    common_error_t          error    = {""};
    const realtime_config_t realtime = {.priority = program->rig->priority,
                                        .cpu      = (int64_t)program->rig->cpu,
                                        .required = program->rig->required != 0};
    program->recorder = program->options->log != NULL ? recorder_start(program->options->log, &error) : NULL;
    const bool has_bus =
        program->bus != NULL && error.text[0] == '\0' &&
        background_start(&program->background, &program->registers, &program->gate, program->bus, &error);
    if (error.text[0] != '\0')
    {
        (void)fprintf(stderr, "%s: %s\n", program_invocation_short_name, error.text);
        return EXIT_SETUP;
    }
    // Comes after the other threads are started, so that they keep an ordinary priority.
    if (!realtime_enter(&realtime, &error))
    {
        (void)fprintf(stderr, "%s: no real time: %s\n", program_invocation_short_name, error.text);
        if (realtime.required)
        {
            return EXIT_SETUP;
        }
        error.text[0] = '\0';
    }
    if (!recorder_open(program->recorder, &error))
    {
        (void)fprintf(stderr, "%s: %s\n", program_invocation_short_name, error.text);
        return EXIT_SETUP;
    }
    const uint64_t ticks = run_ticks(program, heart, &error);
    if (has_bus && !background_stop(&program->background) && error.text[0] == '\0')
    {
        (void)common_error_set(&error,
                               "store: %s: its disk takes too long; the program ends without it",
                               program->rig->store);
    }
    return end(program, ticks, &error);
}

// --- setting up ----------------------------------------------------------------------------------------------------

/// Returns a path of the configuration, relative to its folder.
static void path_of(const char *name, const char *config, char path[2 * RIG_PATH_MAX])
{
    const char *slash  = strrchr(config, '/');
    const int   length = slash != NULL && name[0] != '/' ? (int)(slash - config) + 1 : 0;
    (void)snprintf(path, 2 * RIG_PATH_MAX, "%.*s%s", length < (int)RIG_PATH_MAX ? length : 0, config, name);
}

/// Applies --reference SHAPE or FILE.csv like a --set of the scenario's keys.
static bool set_shape(program_t *program, common_error_t *error)
{
    const char *shape = program->options->shape;
    char        assignment[2 * RIG_PATH_MAX];
    const char *dot    = strrchr(shape, '.');
    const bool  is_csv = dot != NULL && strcmp(dot, ".csv") == 0;
    const int   length = snprintf(assignment, sizeof assignment, "reference.%s=%s", is_csv ? "file" : "kind", shape);
    if (length >= (int)sizeof assignment)
    {
        return common_error_set(error, "--reference: %s is too long", shape);
    }
    return common_scenario_set(program->scenario, assignment, error) &&
           (!is_csv || common_scenario_set(program->scenario, "reference.kind=csv", error));
}

/// Refuses a log that takes no rows, or that would replace a file of this run.
static bool check_log(const program_t *program, const char *scenario, common_error_t *error)
{
    const options_t *options = program->options;
    char             store[2 * RIG_PATH_MAX];
    path_of(program->rig->store, options->config, store);
    char             *reference = common_scenario_reference_path(program->scenario);
    const char *const inputs[]  = {options->config, scenario, reference, store};
    const bool        ok        = options->log == NULL ||
                    (common_file_check_result(options->log, inputs, sizeof inputs / sizeof inputs[0], error) &&
                     common_output_check(options->log, error));
    free(reference);
    return ok;
}

static bool open_scenario(program_t *program, common_error_t *error)
{
    char beside[2 * RIG_PATH_MAX];
    path_of(program->rig->scenario, program->options->config, beside);
    char         *path = common_data_named(beside, common_scenario_folder(), program->rig->scenario);
    const desk_t *desk = program->desk;
    program->scenario  = desk != NULL ? common_scenario_create_of(desk->keys, desk->size)
                                      : common_scenario_create_of(common_loop_keys, sizeof(common_loop_keys_t));
    bool ok            = (program->scenario != NULL && path != NULL) || common_error_set(error, "out of memory");
    ok                 = ok && common_scenario_load(program->scenario, path, error);
    for (unsigned i = 0; ok && i < program->options->set_count; i++)
    {
        ok = common_scenario_set(program->scenario, program->options->sets[i], error);
    }
    ok = ok && (program->options->shape == NULL || set_shape(program, error)) && check_log(program, path, error);
    free(path);
    ok = ok &&
         (desk != NULL ? desk->check(program->scenario, error)
                       : common_check_present(program->scenario, error) && common_check_loop(program->scenario, error));
    return ok && common_check_has_loop(program->scenario, error) &&
           common_reference_init(&program->reference, program->scenario, error);
}

/// Reports an error in the configuration or in its scenario.
static bool complain_of_set(program_t *program, const common_sources_t *sources, common_error_t *error)
{
    const params_error_t *refused = &program->registers.refused;
    char                  what[160];
    (void)snprintf(what,
                   sizeof what,
                   "%.9g does not suit the devices and the loop: %.9g to %.9g is expected",
                   (double)refused->value,
                   (double)refused->low,
                   (double)refused->high);
    if (refused->word < DRIVE_CONFIG_COUNT)
    {
        return rig_complain(sources, program->options->config, params_name(refused->word), what, error);
    }
    return common_error_set(error, "%s: %s: %s", program->rig->scenario, params_name(refused->word), what);
}

static const rig_t *the_rig; // for `suits`, which has no context

/// Keeps the period, because ticks go on as they were set up.
static bool suits(const params_set_t *set, params_error_t *error)
{
    const float period_us = (float)the_rig->drive.period_us;
    *error = (params_error_t){DRIVE_CONFIG_period_us, (float)set->drive.period_us, period_us, period_us, TRIBO_OK};
    return set->drive.period_us == the_rig->drive.period_us;
}

/// Reports which params are in use, and whether they differ from the configuration's.
static void report_params(const program_t *program)
{
    const registers_t *registers = &program->registers;
    // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison,cert-exp42-c,cert-flp37-c): the struct is copied whole, with its padding
    const bool same = memcmp(&registers->active->set, &program->defaults, sizeof program->defaults) == 0;
    (void)fprintf(stderr,
                  "params: %s%s%s\n",
                  program->store.file >= 0 ? "store " : "the configuration's",
                  program->store.file >= 0 ? store_status_text(registers->store) : "",
                  same ? "" : ", and they differ from the configuration's");
    if (registers->is_refused)
    {
        const params_error_t *refused = &registers->refused;
        (void)fprintf(stderr,
                      "params: the store's %s = %.9g is refused: %.9g to %.9g\n",
                      params_name(refused->word),
                      (double)refused->value,
                      (double)refused->low,
                      (double)refused->high);
    }
}

static void add_ceiling(program_t *program, uint16_t word, float low, float high)
{
    program->ceilings[program->ceiling_count++] = (params_ceiling_t){.word = word, .low = low, .high = high};
}

/// Limits scaling and zeros, so that a set cannot make a newton of the loop larger at the motor or the sensor, or make no
/// current some.
static void take_ceilings_of_scaling(program_t *program)
{
    const drive_config_t *drive = &program->defaults.drive;
    add_ceiling(program, DRIVE_CONFIG_command_n_per_unit, drive->command_n_per_unit, FLT_MAX);
    add_ceiling(program, DRIVE_CONFIG_command_zero_units, drive->command_zero_units, drive->command_zero_units);
    add_ceiling(program, DRIVE_CONFIG_sensor_n_per_unit, drive->sensor_n_per_unit, FLT_MAX);
    const float tare_units = drive->tare_max_n / drive->sensor_n_per_unit; // holds for any number of saved tares
    add_ceiling(program,
                DRIVE_CONFIG_sensor_zero_units,
                drive->sensor_zero_units - tare_units,
                drive->sensor_zero_units + tare_units);
}

/// Keeps the residual's model at most a factor of 2 slower than the rig's, and its weight within half of the residual's bound. A
/// slower model, or one with another weight, would expect whatever a broken sensor shows.
static void take_ceilings_of_model(program_t *program)
{
    static const uint16_t quick[] = {DRIVE_CONFIG_actuator_pole_rad_per_s,
                                     DRIVE_CONFIG_sensor_pole_rad_per_s,
                                     PARAMS_STIFFNESS};
    static const uint16_t slow[]  = {PARAMS_INERTIA, PARAMS_DAMPING};
    const params_set_t   *set     = &program->defaults;
    const float           weight  = params_number(set, PARAMS_GRAVITY);
    const float           room    = 0.5f * set->drive.residual_n;
    if (set->drive.residual_n == 0.0f)
    {
        return;
    }
    for (size_t i = 0; i < sizeof quick / sizeof quick[0]; i++)
    {
        add_ceiling(program, quick[i], 0.5f * params_number(set, quick[i]), FLT_MAX);
    }
    for (size_t i = 0; i < sizeof slow / sizeof slow[0]; i++)
    {
        add_ceiling(program, slow[i], 0.0f, 2.0f * params_number(set, slow[i]));
    }
    add_ceiling(program, PARAMS_GRAVITY, weight - room, weight + room);
}

/// Limits the ramp without a host, because a slow one is as good as no fault. Its end may only be nearer to 0.
static void take_ceilings_of_reference(program_t *program)
{
    const drive_config_t *drive = &program->defaults.drive;
    const float           ramp  = drive->reference_ramp_n_per_s;
    const float           safe  = drive->safe_reference_n;
    if (drive->reference_ms > 0u)
    {
        add_ceiling(program, DRIVE_CONFIG_reference_ramp_n_per_s, ramp, ramp > 0.0f ? FLT_MAX : 0.0f);
        add_ceiling(program, DRIVE_CONFIG_safe_reference_n, fminf(safe, 0.0f), fmaxf(safe, 0.0f));
    }
}

/// The configuration sets the widest ranges. The bus and the store may narrow them, and turn on checks that it turns off.
static void take_ceilings(program_t *program)
{
    static const uint16_t rising[] = {PARAMS_INPUT_MAX,
                                      PARAMS_U_MAX,
                                      DRIVE_CONFIG_late_us,
                                      DRIVE_CONFIG_budget_us,
                                      DRIVE_CONFIG_stuck_ticks,
                                      DRIVE_CONFIG_residual_n,
                                      DRIVE_CONFIG_residual_ms,
                                      DRIVE_CONFIG_command_limit_ms,
                                      DRIVE_CONFIG_swing_ms,
                                      DRIVE_CONFIG_reference_ms,
                                      DRIVE_CONFIG_ready_ms,
                                      DRIVE_CONFIG_current_max_a,
                                      DRIVE_CONFIG_command_n_per_a,
                                      DRIVE_CONFIG_residual_slope,
                                      DRIVE_CONFIG_tracking_n,
                                      DRIVE_CONFIG_tracking_ms,
                                      DRIVE_CONFIG_speed_max_units_per_s,
                                      DRIVE_CONFIG_speed_ms,
                                      DRIVE_CONFIG_debounce_n,
                                      DRIVE_CONFIG_over_current_a,
                                      DRIVE_CONFIG_over_current_ms,
                                      DRIVE_CONFIG_bus_high_v,
                                      DRIVE_CONFIG_bus_voltage_ms,
                                      DRIVE_CONFIG_temperature_max_c,
                                      DRIVE_CONFIG_temperature_ms};
    const params_set_t   *set      = &program->defaults;
    for (size_t i = 0; i < sizeof rising / sizeof rising[0]; i++)
    {
        const uint16_t word  = rising[i];
        const bool     drive = word < DRIVE_CONFIG_COUNT;
        const float    high  = drive ? drive_config_value(&set->drive, word) : params_number(set, word);
        const bool     off   = drive && drive_config_fields[word].off;
        if (!off || high > 0.0f)
        {
            add_ceiling(program, word, drive ? drive_config_fields[word].low : 0.0f, high);
        }
    }
    add_ceiling(program, PARAMS_U_MIN, params_number(set, PARAMS_U_MIN), 0.0f);
    add_ceiling(program, DRIVE_CONFIG_tare_max_n, 0.0f, set->drive.tare_max_n);
    if (set->drive.bus_low_v > 0.0f)
    {
        add_ceiling(program, DRIVE_CONFIG_bus_low_v, set->drive.bus_low_v, FLT_MAX);
    }
    if (set->drive.debounce_n > 1u) // of fewer readings, bad ones are rarer
    {
        add_ceiling(program, DRIVE_CONFIG_debounce_m, (float)set->drive.debounce_m, FLT_MAX);
    }
    take_ceilings_of_scaling(program);
    take_ceilings_of_reference(program);
    take_ceilings_of_model(program);
}

static bool open_store(program_t *program, common_error_t *error)
{
    char path[2 * RIG_PATH_MAX];
    path_of(program->rig->store, program->options->config, path);
    return program->rig->store[0] == '\0' || params_file_open(&program->store, path, error);
}

/// Keeps poles that the configuration names itself; the scenario's feed-forward gives the others.
static void keep_poles(drive_config_t *drive, const drive_config_t *named, const common_sources_t *sources)
{
    if (common_sources_has(sources, "drive.actuator_pole_rad_per_s"))
    {
        drive->actuator_pole_rad_per_s = named->actuator_pole_rad_per_s;
    }
    if (common_sources_has(sources, "drive.sensor_pole_rad_per_s"))
    {
        drive->sensor_pole_rad_per_s = named->sensor_pole_rad_per_s;
    }
}

/// Sets up the application behind its registers, with the configuration's params as the board's defaults.
static bool set_up_drive(program_t *program, const common_sources_t *sources, common_error_t *error)
{
    const common_loop_keys_t *config    = common_scenario_loop(program->scenario);
    const char               *path      = program->options->config;
    registers_t              *registers = &program->registers;
    common_loop_config_t      loop;
    if ((uint32_t)(config->sample_time_s * 1e6 + 0.5) != program->rig->drive.period_us)
    {
        char what[160];
        (void)snprintf(what,
                       sizeof what,
                       "%u is not the scenario's sample_time_s of %g",
                       program->rig->drive.period_us,
                       config->sample_time_s);
        return rig_complain(sources, path, "drive.period_us", what, error);
    }
    common_loop_config_fill(&loop, config);
    program->defaults       = params_default();
    program->defaults.drive = program->rig->drive;
    params_take_loop(&program->defaults, &loop.parts);
    keep_poles(&program->defaults.drive, &program->rig->drive, sources);
    take_ceilings(program);
    if (!open_store(program, error))
    {
        return false;
    }
    the_rig                       = program->rig;
    const registers_board_t parts = {.port          = &program->board.port,
                                     .line          = &background_line,
                                     .flash         = program->store.file >= 0 ? &program->store.flash : NULL,
                                     .defaults      = &program->defaults,
                                     .suits         = suits,
                                     .ceilings      = program->ceilings,
                                     .ceiling_count = program->ceiling_count,
                                     .has_reference = program->options->has_reference,
                                     .baud          = (uint32_t)program->rig->bus.baud,
                                     .ring          = program->ring,
                                     .ring_words    = TRACE_WORDS};
    registers_load(registers, &parts);
    if (!registers->is_made && registers->is_refused)
    {
        return complain_of_set(program, sources, error);
    }
    return true;
}

/// Makes the reference of the command line or the scenario, unless the bus sets it.
static bool check_given_reference(const program_t *program, common_error_t *error)
{
    const options_t *options = program->options;
    switch (options->reference)
    {
    case REFERENCE_CONSTANT:
        return check_reference(program, "--reference", fabs(options->constant_n), error);
    case REFERENCE_SCENARIO:
        return (bus_is_used(&program->rig->bus) && !options->has_reference) ||
               check_reference(program, "reference", common_reference_peak(&program->reference), error);
    default:
        return true;
    }
}

static bool open_ticks(program_t *program, common_error_t *error)
{
    const char *ticks = program->options->ticks;
    program->ticks_in = program->ticks_out = -1;
    if (ticks == NULL)
    {
        return true;
    }
    char        in[RIG_PATH_MAX + 1];
    const char *comma = strchr(ticks, ',');
    (void)snprintf(in, sizeof in, "%.*s", (int)(comma - ticks), ticks);
    program->ticks_in  = open(in, O_RDONLY | O_CLOEXEC);
    program->ticks_out = program->ticks_in >= 0 ? open(comma + 1, O_WRONLY | O_CLOEXEC) : -1;
    return program->ticks_out >= 0 || common_error_set(error, "--ticks %s: %s", ticks, strerror(errno));
}

static bool open_bus(program_t *program, common_error_t *error)
{
    program->bus = bus_is_used(&program->rig->bus) ? bus_open(&program->rig->bus, error) : NULL;
    return error->text[0] == '\0';
}

/// With ticks from outside, each tick is one period, however long it takes.
static int64_t slack_of(const program_t *program)
{
    return program->options->ticks != NULL ? INT64_MAX : (int64_t)program->rig->catch_up_ms * NS_PER_MS;
}

/// Checks whether the watchdog exists; opening it would arm it.
static bool find_watchdog(const program_t *program, common_error_t *error)
{
    const char *watchdog = rig_watchdog(program->rig);
    if (program->desk != NULL)
    {
        return true;
    }
    if (watchdog == NULL)
    {
        (void)fputs("watchdog: none, so nothing turns the outputs off if the kernel hangs\n", stderr);
        return true;
    }
    return access(watchdog, W_OK) == 0 || common_error_set(error, "watchdog: %s: %s", watchdog, strerror(errno));
}

/// A rig's CPU must exist, and that of a desk unless it may run without real time.
static bool find_cpu(const program_t *program, common_error_t *error)
{
    if (realtime_check_cpu((int64_t)program->rig->cpu, error))
    {
        return true;
    }
    const bool goes_on = program->desk != NULL && !program->rig->required;
    if (goes_on)
    {
        (void)fprintf(stderr, "%s: no real time: %s\n", program_invocation_short_name, error->text);
        error->text[0] = '\0';
    }
    return goes_on;
}

/// Checks the sensor's keys, unless the scenario needs no sensor.
static bool find_sensor(const program_t *program, const common_sources_t *sources, common_error_t *error)
{
    const bool needs = common_scenario_loop(program->scenario)->compensator.sensor != COMMON_SENSOR_NONE;
    return !needs || program->desk != NULL || rig_has_sensor(program->rig) ||
           rig_complain(sources, program->options->config, "sensor.device", "is missing", error);
}

static int open_and_run(program_t *program, const common_sources_t *sources, common_error_t *error)
{
    if (!open_scenario(program, error) || !find_sensor(program, sources, error) || !find_cpu(program, error) ||
        !find_watchdog(program, error) ||
        !board_open(&program->board, program->rig, program->desk, program->scenario, error))
    {
        return -1;
    }
    int status = -1;
    if (set_up_drive(program, sources, error) && check_given_reference(program, error) && open_bus(program, error))
    {
        program->board.slack_ns = slack_of(program);
        registers_start(&program->registers, selftest_golden());
        report_params(program);
        drive_report_off(&program->board.port, &program->registers.active->set.drive);
        const supervisor_config_t supervisor = {.heartbeat_ms = program->rig->heartbeat_ms,
                                                .priority     = program->rig->priority + 1u,
                                                .watchdog   = program->desk == NULL ? rig_watchdog(program->rig) : NULL,
                                                .watchdog_s = program->rig->watchdog_s,
                                                .off        = board_off,
                                                .context    = &program->board};
        const bool                ok         = board_attach(&program->board, &program->registers.drive, error);
        status                               = ok && program->options->check ? EXIT_OK
                                               : ok && open_ticks(program, error) ? supervisor_run(&supervisor, run, program, error)
                                                                                  : -1;
        if (status == EXIT_OK && program->options->check)
        {
            (void)printf("%s: everything is open, nothing has moved\n", program_invocation_short_name);
        }
    }
    board_off(&program->board);
    board_close(&program->board);
    bus_close(program->bus);
    params_file_close(&program->store);
    return status;
}

int program_run(int count, char **arguments, const desk_t *desk)
{
    static program_t         program;
    static rig_t             rig;
    static options_t         options;
    static const struct argp argp = {
        .options  = known,
        .parser   = take,
        .args_doc = "CONFIG.yaml",
        .doc = "Friction-compensated force control on a Linux board: runs the loop of a scenario on IIO, PWM and GPIO, "
               "or as "
               "tribo-desk on the scenario's plant.\v"
               "Exit status: 0 done, 1 configuration, devices or log, 2 command line, 3 stopped for a fault."};
    common_output_fill_descriptors();
    messages_begin();
    argp_err_exit_status = EXIT_USAGE;
    options.name         = desk != NULL ? "tribo-desk" : "tribo-drive";
    (void)argp_parse(&argp, count, arguments, ARGP_NO_HELP, NULL, &options);
    if (options.keys)
    {
        rig_print_keys();
        return finish(EXIT_OK);
    }
    common_sources_t sources = {.count = 0};
    common_error_t   error   = {""};
    program.options          = &options;
    program.desk             = desk;
    program.rig              = &rig;
    program.store.file       = -1;
    const int status =
        rig_load(&rig, options.config, desk != NULL, &sources, &error) ? open_and_run(&program, &sources, &error) : -1;
    if (error.text[0] != '\0')
    {
        (void)fprintf(stderr, "%s: %s\n", program_invocation_short_name, error.text);
    }
    common_reference_free(&program.reference);
    common_scenario_destroy(program.scenario);
    common_sources_free(&sources);
    return status >= 0 ? finish(status) : EXIT_SETUP;
}
