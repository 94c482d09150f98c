#include "sim/scenario_choice.h"

#include "sim/commands.h"
#include "support/data_path.h"
#include "support/file.h"
#include "support/text.h"

#include <stdlib.h>
#include <string.h>

char *sim_scenario_path(const char *name)
{
    return common_data_named(name, common_scenario_folder(), name);
}

int sim_scenario_take_set(sim_scenario_choice_t *choice, const char *assignment)
{
    if (strchr(assignment, '=') == NULL || assignment[0] == '=')
    {
        return sim_usage("--set %s: key=value is expected", assignment);
    }
    const char **larger =
        (const char **)realloc((void *)choice->sets, ((size_t)choice->set_count + 1) * sizeof *larger);
    if (larger == NULL)
    {
        return sim_failure("out of memory");
    }
    choice->sets                      = larger;
    choice->sets[choice->set_count++] = assignment;
    return 0;
}

int sim_scenario_check_arithmetic(const sim_scenario_choice_t *choice, int most)
{
    for (int i = 0; i < choice->set_count; i++)
    {
        most -= strncmp(choice->sets[i], "arithmetic=", strlen("arithmetic=")) == 0 ? 1 : 0;
    }
    return most >= 0 ? 0 : sim_usage("--arith and --set arithmetic: only one is expected");
}

void sim_scenario_choice_free(sim_scenario_choice_t *choice)
{
    free((void *)choice->sets);
}

static bool load(common_scenario_t           *scenario,
                 const sim_scenario_choice_t *choice,
                 const char                  *path,
                 common_error_t              *error)
{
    bool ok =
        common_file_exists(path)
            ? common_scenario_load(scenario, path, error)
            : common_error_set(error,
                               "%s: there is no such file, and no such scenario in %s (tribo-sim list shows them)",
                               path,
                               common_scenario_folder());
    ok = ok && (choice->learned == NULL || common_scenario_load_compensator(scenario, choice->learned, error));
    for (int i = 0; ok && i < choice->set_count; i++)
    {
        ok = common_scenario_set(scenario, choice->sets[i], error);
    }
    return ok && sim_scenario_check(scenario, error);
}

common_scenario_t *sim_scenario_open(const sim_scenario_choice_t *choice, common_error_t *error)
{
    char              *path     = sim_scenario_path(choice->name);
    common_scenario_t *scenario = sim_scenario_create();
    if (path == NULL || scenario == NULL)
    {
        (void)common_error_set(error, "out of memory");
    }
    else if (load(scenario, choice, path, error))
    {
        free(path);
        return scenario;
    }
    free(path);
    common_scenario_destroy(scenario);
    return NULL;
}
