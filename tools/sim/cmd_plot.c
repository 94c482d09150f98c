// Draws the files of the other commands and of a drive.

#include "sim/commands.h"
#include "sim/tool.h"

#include <stdlib.h>
#include <string.h>

typedef struct
{
    const char **words; ///< arguments of tribo-plot: the first is its name, a null follows the last
    size_t       count;
    bool         has_out;
} options_t;

enum
{
    OPTION_OUT = SIM_OPTION_FIRST,
    OPTION_FROM,
    OPTION_TO,
    OPTION_NAME,
    OPTION_ALL
};

// clang-format off: one row an option
static const struct argp_option known[] = {
    {.name = "out", .key = OPTION_OUT, .arg = "FILE.png|svg|html|mcap", .doc = "the file to write; an HTML page zooms and needs no network"},
    {.name = "from", .key = OPTION_FROM, .arg = "S", .doc = "draws from this time on"},
    {.name = "to", .key = OPTION_TO, .arg = "S", .doc = "draws until this time"},
    {.name = "name", .key = OPTION_NAME, .arg = "TEXT", .doc = "names a run in the picture; may be repeated, in the order of the runs"},
    {.name = "all", .key = OPTION_ALL, .doc = "also draws learned values, relays, position and friction over net force; without it force, error and command"},
    {.name = NULL}};
// clang-format on

static int take(void *context, int key, const char *value)
{
    static const char *const names[] = {"--out", "--from", "--to", "--name", "--all"};
    options_t               *options = context;
    if (key != SIM_OPTION_ARGUMENT)
    {
        options->words[options->count++] = names[key - SIM_OPTION_FIRST];
        options->has_out                 = options->has_out || key == OPTION_OUT;
    }
    if (value != NULL)
    {
        options->words[options->count++] = value;
    }
    return 0;
}

static int run(int count, char **arguments)
{
    // At most two words for each argument.
    options_t options = {.words = (const char **)calloc(2u * (size_t)count + 1u, sizeof(char *))};
    if (options.words == NULL)
    {
        return sim_failure("out of memory");
    }
    options.words[options.count++] = "tribo-plot";
    int status                     = sim_options_parse(&sim_command_plot, count, arguments, &options, NULL);
    if (status == 0)
    {
        status = options.has_out ? sim_tool_run(options.words) : sim_usage("plot: --out FILE is expected");
    }
    free((void *)options.words);
    return status;
}

const sim_command_t sim_command_plot = {.name     = "plot",
                                        .argument = "DIR|FILE.csv...",
                                        .noun     = "folder or file",
                                        .is_many  = true,
                                        .text    = "Draws runs, replays, traces and logs of a drive, several on top of "
                                                   "each other, or a sweep (Python, matplotlib).",
                                        .options = known,
                                        .run     = run,
                                        .take    = take};
