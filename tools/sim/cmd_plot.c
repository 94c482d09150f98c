// Draws the files of the other commands and of a drive.

#include "sim/commands.h"
#include "sim/tool.h"
#include "support/text.h"

#include <stdlib.h>
#include <string.h>

typedef struct
{
    char **words; ///< arguments of tribo-plot; a null follows the last
    size_t count;
    bool   has_out;
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

/// Makes one word of an option with its value. tribo-plot would take a value or a path that begins with - for an option.
static int take(void *context, int key, const char *value)
{
    options_t  *options              = context;
    const bool  is_path              = key == SIM_OPTION_ARGUMENT;
    const char *name                 = is_path ? "" : known[key - SIM_OPTION_FIRST].name;
    char       *word                 = is_path         ? common_text_format("%s%s", value[0] == '-' ? "./" : "", value)
                                       : value == NULL ? common_text_format("--%s", name)
                                                       : common_text_format("--%s=%s", name, value);
    options->has_out                 = options->has_out || key == OPTION_OUT;
    options->words[options->count++] = word;
    return word != NULL ? 0 : sim_failure("out of memory");
}

static int run(int count, char **arguments)
{
    char     *name    = strdup("tribo-plot");
    options_t options = {.words = (char **)calloc((size_t)count + 2u, sizeof(char *)), .count = 1};
    if (options.words == NULL || name == NULL)
    {
        free(name);
        free((void *)options.words);
        return sim_failure("out of memory");
    }
    options.words[0] = name;
    int status       = sim_options_parse(&sim_command_plot, count, arguments, &options, NULL);
    if (status == 0)
    {
        status = options.has_out ? sim_tool_run((const char *const *)options.words)
                                 : sim_usage("plot: --out FILE is expected");
    }
    for (size_t i = 0; i < options.count; i++)
    {
        free(options.words[i]);
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
