// Reads raw logs and writes one clean log: it makes replay's reader available to programs not written in C.

#include "sim/commands.h"
#include "sim/log_options.h"
#include "support/output_file.h"

#include <stdio.h>

typedef struct
{
    sim_log_arguments_t logs;
    const char         *out; ///< null: standard output
} options_t;

enum
{
    OPTION_OUT = SIM_OPTION_FIRST
};

// clang-format off: one row an option
static const struct argp_option known[] = {
    {.name = "out", .key = OPTION_OUT, .arg = "OUT.csv", .doc = "the file to write; standard output if left out"},
    SIM_LOG_OPTIONS,
    {.name = NULL}};
// clang-format on

static int take(void *context, int key, const char *value)
{
    options_t *options = context;
    if (key == OPTION_OUT)
    {
        options->out = value;
        return 0;
    }
    return sim_log_take(&options->logs, key, value);
}

static const char *const names[SIM_LOG_ROLES] = {"t_s", "u_N", "F_N", "x_deg", "w_deg_per_s", "r_N"};

static void write_log(const sim_log_t *log, FILE *file)
{
    for (size_t i = 0; i < SIM_LOG_ROLES; i++)
    {
        if (log->values[i] != NULL)
        {
            (void)fprintf(file, "%s,", names[i]);
        }
    }
    (void)fputs("segment\n", file);
    for (size_t s = 0; s < log->segments; s++)
    {
        for (size_t k = log->starts[s]; k < log->starts[s + 1] && !ferror(file); k++)
        {
            (void)fprintf(file, "%.15g,", log->values[SIM_LOG_T][k]);
            for (size_t i = SIM_LOG_U; i < SIM_LOG_ROLES; i++)
            {
                if (log->values[i] != NULL)
                {
                    (void)fprintf(file, "%.9g,", log->values[i][k]);
                }
            }
            (void)fprintf(file, "%zu\n", s);
        }
    }
}

static bool convert(const options_t *options, common_error_t *error)
{
    sim_log_t            log;
    common_output_file_t file;
    if (!common_output_check(options->out, error) ||
        !sim_log_read(&log, options->logs.paths, options->logs.count, &options->logs.options, error))
    {
        return false;
    }
    bool ok = common_output_open(&file, options->out, error);
    if (ok)
    {
        write_log(&log, file.stream);
        ok = common_output_commit(&file, 1, error);
    }
    if (ok)
    {
        sim_log_report(&log, options->logs.paths[0]);
    }
    sim_log_free(&log);
    return ok;
}

static int run(int count, char **arguments)
{
    options_t      options = {.out = NULL};
    common_error_t error   = {""};
    int            status  = sim_options_parse(&sim_command_log, count, arguments, &options, NULL);
    if (status == 0)
    {
        status = sim_log_check(&options.logs, "log", "out", options.out);
    }
    if (status != 0)
    {
        return status;
    }
    options.logs.options.command_optional = true;
    return convert(&options, &error) ? SIM_EXIT_OK : sim_failure(error.text);
}

const sim_command_t sim_command_log = {
    .name     = "log",
    .argument = "LOG.csv...",
    .noun     = "log",
    .is_many  = true,
    .text     = "Reads recorded logs of many formats and writes one clean log: t_s, u_N, F_N and the other columns.",
    .options  = known,
    .run      = run,
    .take     = take};
