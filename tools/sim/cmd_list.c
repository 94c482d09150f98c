#include "scenario/config.h"
#include "scenario/key_list.h"
#include "scenario/parameter_list.h"
#include "sim/commands.h"
#include "support/data_path.h"
#include "support/output_file.h"
#include "support/text.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int is_scenario(const struct dirent *entry)
{
    const size_t length = strlen(entry->d_name);
    return length > 5 && entry->d_name[0] != '.' && strcmp(entry->d_name + length - 5, ".yaml") == 0;
}

/// One line: the name without its ending, and the description or the file's error.
static bool print_scenario(const char *folder, const char *file, common_error_t *error)
{
    common_error_t     problem  = {""};
    char              *path     = common_text_format("%s/%s", folder, file);
    common_scenario_t *scenario = sim_scenario_create();
    const bool         ok       = path != NULL && scenario != NULL;
    if (ok)
    {
        const bool  is_good = common_scenario_load(scenario, path, &problem);
        const char *text    = is_good ? sim_scenario_config(scenario)->description : problem.text;
        (void)printf("%-16.*s%s\n", (int)strlen(file) - 5, file, text);
    }
    common_scenario_destroy(scenario);
    free(path);
    return ok || common_error_set(error, "out of memory");
}

static bool list_folder(const char *folder, common_error_t *error)
{
    struct dirent **entries;
    const int       count = scandir(folder, &entries, is_scenario, alphasort);
    if (count < 0)
    {
        return common_error_set(error, "%s: cannot be read: %s", folder, strerror(errno));
    }
    bool ok = true;
    for (int i = 0; i < count; i++)
    {
        ok = ok && print_scenario(folder, entries[i]->d_name, error);
        free(entries[i]);
    }
    free((void *)entries);
    return ok;
}

enum
{
    OPTION_KEYS = SIM_OPTION_FIRST,
    OPTION_MARKDOWN,
    OPTION_PARAMETERS
};

// clang-format off: one row an option
static const struct argp_option options[] = {
    {.name = "keys", .key = OPTION_KEYS, .doc = "every key that a scenario can have, with its range and default"},
    {.name = "markdown", .key = OPTION_MARKDOWN, .doc = "these keys as tables in Markdown, with units and meanings"},
    {.name = "parameters", .key = OPTION_PARAMETERS, .doc = "every parameter of the library with its field, as tables in Markdown"},
    {.name = NULL}};
// clang-format on

/// Keeps the option. --markdown is that of --keys, with or without it.
static int take(void *context, int key, const char *value)
{
    int *const what = context;
    (void)value;
    if (*what != 0 && *what != key && (*what == OPTION_PARAMETERS || key == OPTION_PARAMETERS))
    {
        return sim_usage("list: --parameters goes with no other option");
    }
    *what = key > *what ? key : *what;
    return 0;
}

static int run(int count, char **arguments)
{
    int            what   = 0;
    common_error_t error  = {""};
    bool           ok     = true;
    const char    *unused = NULL;
    const int      status = sim_options_parse(&sim_command_list, count, arguments, &what, &unused);
    if (status != 0)
    {
        return status;
    }
    switch (what)
    {
    case OPTION_KEYS:
        sim_key_list_print();
        break;
    case OPTION_MARKDOWN:
        sim_key_list_print_markdown();
        break;
    case OPTION_PARAMETERS:
        sim_parameter_list_print();
        break;
    default:
        ok = list_folder(common_scenario_folder(), &error);
    }
    return (ok && common_output_flush(&error)) ? SIM_EXIT_OK : sim_failure(error.text);
}

const sim_command_t sim_command_list = {
    .name    = "list",
    .text    = "Lists the scenarios of the scenarios folder, all keys, or the library's parameters.",
    .options = options,
    .run     = run,
    .take    = take};
