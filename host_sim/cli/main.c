// tribo-sim: the force loop of lib/ on the host, with a simulated plant or with a recorded log.

#include "cli/commands.h"
#include "support/output_file.h"

#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static const char help[] =
    "tribo-sim: friction-compensated force control, simulated\n"
    "\n"
    "  tribo-sim run SCENARIO.yaml [--set key=value]... [--out DIR] [--json]\n"
    "                [--arith f32|q31|both] [--target NAME]\n"
    "      Plays a scenario: a path, or the name of one in the scenarios folder.\n"
    "      --set key=value   changes any key, e.g. compensator.gain=0\n"
    "      --out DIR         writes DIR/trace.csv (one row a tick) and DIR/summary.json\n"
    "      --json            prints the summary as JSON instead of a table\n"
    "      --target NAME     runs the drive's firmware on an emulated microcontroller against the plant here, and "
    "compares\n"
    "                        it with the host, bit by bit: m0, m3, m4f, m7, m33, rv32imc or rv32imafc\n"
    "      --arith ARITH     f32 (if left out), q31, or both: two loops on two plants and how they differ\n"
    "\n"
    "  tribo-sim replay LOG.csv [--params FILE.yaml] [--force own|measured] [--out OUT.csv]\n"
    "                [--arith f32|q31|both] [--full-scale N]\n"
    "      Runs a recorded log (columns t_s, u_N and maybe F_N) through the friction compensator.\n"
    "      --params FILE     keys of a scenario's `compensator`; the paper's values if left out\n"
    "      --force own       F is the compensator's own arm model's (default)\n"
    "      --force measured  F is the log's F_N\n"
    "      --out OUT.csv     where the result goes; standard output if left out\n"
    "      --arith ARITH     f32 (if left out), q31, or both: Q31's columns beside f32's, and how they differ\n"
    "      --full-scale N    what 2^31 stands for in Q31, 2 N if left out\n"
    "\n"
    "  tribo-sim params SCENARIO.yaml [--arith f32|q31] [--set key=value]... [--name NAME] [--out FILE.h]\n"
    "      Writes the scenario's loop as checked params in C, for firmware without set-up code.\n"
    "      --name NAME       NAME_params is declared; the scenario's name if left out\n"
    "      --out FILE.h      where it goes; standard output if left out\n"
    "\n"
    "  tribo-sim list [--keys]\n"
    "      Lists the scenarios of the scenarios folder, or every key that a scenario can have.\n"
    "\n"
    "The scenarios folder is the one named by TRIBO_SCENARIOS, or else the one tribo-sim came with; the\n"
    "images for --target are in the one named by TRIBO_FIRMWARE, or else where the presets build them.\n"
    "Exit status: 0 done, 1 something is wrong with a file, a value or the run, 2 with the command line.\n";

int sim_usage(const char *format, ...)
{
    va_list args;
    (void)fputs("tribo-sim: ", stderr);
    va_start(args, format);
    (void)vfprintf(stderr, format, args);
    va_end(args);
    (void)fputs(" (tribo-sim --help shows what there is)\n", stderr);
    return SIM_EXIT_USAGE;
}

int sim_failure(const char *message)
{
    (void)fprintf(stderr, "tribo-sim: %s\n", message);
    return SIM_EXIT_ERROR;
}

static int show_help(void)
{
    return (fputs(help, stdout) >= 0 && fflush(stdout) == 0) ? SIM_EXIT_OK : SIM_EXIT_ERROR;
}

int main(int count, char **arguments)
{
    static const struct
    {
        const char *name;
        int (*command)(int count, char **arguments);
    } commands[] = {{"run", sim_command_run},
                    {"replay", sim_command_replay},
                    {"params", sim_command_params},
                    {"list", sim_command_list}};

    // A file size limit and a closed pipe are then write errors, reported like any other.
    (void)signal(SIGXFSZ, SIG_IGN);
    (void)signal(SIGPIPE, SIG_IGN);
    sim_output_file_clean_on_signal();

    if (count < 2)
    {
        return sim_usage("a command is wanted: run, replay, params or list");
    }
    for (int i = 1; i < count && strcmp(arguments[i], "--") != 0; i++)
    {
        if (strcmp(arguments[i], "--help") == 0 || strcmp(arguments[i], "-h") == 0)
        {
            return show_help();
        }
    }
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++)
    {
        if (strcmp(arguments[1], commands[i].name) == 0)
        {
            return commands[i].command(count - 1, arguments + 1);
        }
    }
    return sim_usage("unknown command %s", arguments[1]);
}
