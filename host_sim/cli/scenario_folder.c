#include "cli/scenario_folder.h"

#include "cli/commands.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

const char *sim_scenario_folder(void)
{
    const char *chosen = getenv("TRIBO_SCENARIOS");
    if (chosen != NULL && chosen[0] != '\0')
    {
        return chosen;
    }
    return access(TRIBO_SCENARIOS_SOURCE, R_OK) == 0 ? TRIBO_SCENARIOS_SOURCE : TRIBO_SCENARIOS_INSTALLED;
}

static bool exists(const char *path)
{
    return access(path, F_OK) == 0;
}

char *sim_scenario_path(const char *name)
{
    if (exists(name) || strchr(name, '/') != NULL)
    {
        return strdup(name);
    }
    const char  *folder = sim_scenario_folder();
    const size_t size   = strlen(folder) + strlen(name) + sizeof "/.yaml";
    char        *path   = malloc(size);
    if (path == NULL)
    {
        return NULL;
    }
    static const char *const endings[] = {"", ".yaml"};
    for (size_t i = 0; i < 2; i++)
    {
        (void)snprintf(path, size, "%s/%s%s", folder, name, endings[i]);
        if (exists(path))
        {
            return path;
        }
    }
    free(path);
    return strdup(name);
}

int sim_scenario_take_set(sim_scenario_choice_t *choice, char *assignment)
{
    if (strchr(assignment, '=') == NULL || assignment[0] == '=')
    {
        return sim_usage("--set %s: key=value is wanted", assignment);
    }
    choice->sets[choice->set_count++] = assignment;
    return 0;
}

bool sim_scenario_open(sim_scenario_t *scenario, const sim_scenario_choice_t *choice, sim_error_t *error)
{
    char *path = sim_scenario_path(choice->name);
    if (path == NULL)
    {
        return sim_error_set(error, "out of memory");
    }
    bool ok = exists(path)
                  ? sim_scenario_load(scenario, path, error)
                  : sim_error_set(error,
                                  "%s: there is no such file, nor such a scenario in %s (tribo-sim list shows them)",
                                  path,
                                  sim_scenario_folder());
    for (int i = 0; ok && i < choice->set_count; i++)
    {
        ok = sim_scenario_set(scenario, choice->sets[i], error);
    }
    free(path);
    return ok && sim_scenario_check(scenario, error);
}
