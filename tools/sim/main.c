// tribo-sim: the force loop of lib/ on the host, with a simulated plant or with a recorded log.

#include "sim/commands.h"
#include "support/error.h"
#include "support/output_file.h"
#include "target/target.h"

#include "tribo/status.h"

#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static const sim_command_t *const commands[] = {&sim_command_run,
                                                &sim_command_replay,
                                                &sim_command_log,
                                                &sim_command_plot,
                                                &sim_command_params,
                                                &sim_command_fmu,
                                                &sim_command_list};

#define COMMANDS (sizeof commands / sizeof commands[0])

int sim_usage(const char *format, ...)
{
    common_error_t error = {""};
    va_list        args;
    va_start(args, format);
    common_error_set_list(&error, format, args);
    va_end(args);
    (void)fprintf(stderr, "tribo-sim: %s (tribo-sim --help lists the commands)\n", error.text);
    return SIM_EXIT_USAGE;
}

int sim_failure(const char *message)
{
    (void)fprintf(stderr, "tribo-sim: %s\n", message);
    return SIM_EXIT_ERROR;
}

static int flushed(void)
{
    common_error_t error = {""};
    return common_output_flush(&error) ? SIM_EXIT_OK : sim_failure(error.text);
}

static const sim_command_t *find_command(const char *name)
{
    for (size_t i = 0; i < COMMANDS; i++)
    {
        if (strcmp(name, commands[i]->name) == 0)
        {
            return commands[i];
        }
    }
    return NULL;
}

/// Prints the help of one command, or of all if it is null.
static int show_help(const sim_command_t *command)
{
    if (command != NULL)
    {
        sim_options_help(command);
    }
    else
    {
        (void)puts("Usage: tribo-sim COMMAND [OPTION...]\n"
                   "Friction-compensated force control, simulated.\n");
        for (size_t i = 0; i < COMMANDS; i++)
        {
            (void)printf("  %-8s%s\n", commands[i]->name, commands[i]->text);
        }
        (void)puts("\ntribo-sim COMMAND --help shows its options, tribo-sim --version the version.\n");
    }
    if (command == NULL || command == &sim_command_run)
    {
        (void)printf("Targets: %s.\n", sim_target_names());
    }
    (void)puts("The folder of scenarios came with tribo-sim; TRIBO_SCENARIOS names another. The\n"
               "images for --target are in the folder TRIBO_FIRMWARE, or where the presets build them.\n"
               "Exit status: 0 done, 1 an error in a file, a value or the run, 2 an error in the command line.");
    return flushed();
}

int main(int count, char **arguments)
{
    common_output_fill_descriptors();
    // Makes a file size limit and a closed pipe ordinary write errors.
    (void)signal(SIGXFSZ, SIG_IGN);
    (void)signal(SIGPIPE, SIG_IGN);
    common_output_clean_on_signal();

    if (count < 2)
    {
        return sim_usage("a command is expected: run, replay, log, plot, params, fmu or list");
    }
    const sim_command_t *const command = find_command(arguments[1]);
    if (strcmp(arguments[1], "--version") == 0)
    {
        (void)puts("tribo-sim " TRIBO_VERSION_STRING);
        return flushed();
    }
    for (int i = 1; i < count && strcmp(arguments[i], "--") != 0; i++)
    {
        if (strcmp(arguments[i], "--help") == 0 || strcmp(arguments[i], "-h") == 0)
        {
            return show_help(command);
        }
    }
    return command != NULL ? command->run(count - 1, arguments + 1) : sim_usage("unknown command %s", arguments[1]);
}
