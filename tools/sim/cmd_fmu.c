// Makes FMUs.

#include "sim/commands.h"
#include "sim/scenario_choice.h"
#include "sim/tool.h"
#include "support/text.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

typedef struct
{
    const char *part, *fmi, *out; ///< null: not given
    bool        has_arith, q31;
} options_t;

enum
{
    OPTION_PART = SIM_OPTION_FIRST,
    OPTION_FMI,
    OPTION_ARITH,
    OPTION_OUT
};

// clang-format off: one row an option
static const struct argp_option known[] = {
    {.name = "part", .key = OPTION_PART, .arg = "loop|compensator|plant", .doc = "the part of the scenario"},
    {.name = "out", .key = OPTION_OUT, .arg = "FILE.fmu", .doc = "the file to write"},
    {.name = "fmi", .key = OPTION_FMI, .arg = "2|3", .doc = "the version of FMI; 2 if left out"},
    {.name = "arith", .key = OPTION_ARITH, .arg = "f32|q31", .doc = "the loop's arithmetic; f32 if left out"},
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
    const int word = sim_option_word(&sim_command_fmu, key, value);
    if (key == OPTION_PART)
    {
        options->part = value;
    }
    else if (key == OPTION_FMI)
    {
        options->fmi = value;
    }
    else
    {
        options->has_arith = true;
        options->q31       = word == 1;
    }
    return word >= 0 ? 0 : SIM_EXIT_USAGE;
}

static int run(int count, char **arguments)
{
    options_t   options  = {.fmi = "2"};
    const char *scenario = NULL;
    const int   status   = sim_options_parse(&sim_command_fmu, count, arguments, &options, &scenario);
    if (status != 0)
    {
        return status;
    }
    if (options.part == NULL || options.out == NULL)
    {
        return sim_usage("fmu: --part %s and --out FILE.fmu are expected",
                         options.part != NULL ? options.part : "loop");
    }
    if (options.has_arith && strcmp(options.part, "loop") != 0)
    {
        return sim_usage("fmu: --arith is the loop's, and --part %s has none", options.part);
    }
    char *const path      = sim_scenario_path(scenario);
    char *const out       = common_text_format("--out=%s", options.out); // one word, as a name may begin with -
    const char *words[10] = {"tribo-fmu", out, "--part", options.part, "--fmi", options.fmi};
    size_t      used      = 6;
    if (options.q31)
    {
        words[used++] = "--q31";
    }
    words[used++]  = "--";
    words[used]    = path;
    const int done = path != NULL && out != NULL ? sim_tool_run(words) : sim_failure("out of memory");
    free(path);
    free(out);
    return done;
}

const sim_command_t sim_command_fmu = {.name     = "fmu",
                                       .argument = "SCENARIO.yaml",
                                       .noun     = "scenario",
                                       .text     = "Makes an FMU of a scenario's loop, compensator or plant, for other "
                                                   "simulators (Python, CMake, a C compiler).",
                                       .options  = known,
                                       .run      = run,
                                       .take     = take};
