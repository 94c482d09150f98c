#include "cli/commands.h"
#include "cli/scenario_folder.h"
#include "scenario/config.h"
#include "scenario/key_list.h"
#include "support/output_file.h"

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

/// One line: the name without its ending, and the description or what is wrong with the file.
static bool print_scenario(const char *folder, const char *file, sim_error_t *error)
{
    const size_t    size     = strlen(folder) + strlen(file) + 2;
    char           *path     = malloc(size);
    sim_scenario_t *scenario = sim_scenario_create();
    const bool      ok       = path != NULL && scenario != NULL;
    if (ok)
    {
        sim_error_t problem = {""};
        (void)snprintf(path, size, "%s/%s", folder, file);
        const bool  loaded      = sim_scenario_load(scenario, path, &problem);
        const char *description = sim_scenario_config(scenario)->description;
        (void)printf("%-16.*s%s\n", (int)(strlen(file) - 5), file, !loaded ? problem.text : description);
    }
    else
    {
        (void)sim_error_set(error, "out of memory");
    }
    sim_scenario_destroy(scenario);
    free(path);
    return ok;
}

static bool list_folder(const char *folder, sim_error_t *error)
{
    struct dirent **entries;
    const int       count = scandir(folder, &entries, is_scenario, alphasort);
    if (count < 0)
    {
        return sim_error_set(error, "%s: cannot be read: %s", folder, strerror(errno));
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

int sim_command_list(int count, char **arguments)
{
    sim_error_t error = {""};
    bool        ok;
    if (count == 2 && strcmp(arguments[1], "--keys") == 0)
    {
        sim_key_list_print();
        ok = true;
    }
    else if (count == 2 && strcmp(arguments[1], "--markdown") == 0)
    {
        sim_key_list_print_markdown();
        ok = true;
    }
    else if (count == 1)
    {
        ok = list_folder(sim_scenario_folder(), &error);
    }
    else
    {
        return sim_usage("list: unknown argument %s", arguments[1]);
    }
    return (ok && sim_output_flush(&error)) ? SIM_EXIT_OK : sim_failure(error.text);
}
