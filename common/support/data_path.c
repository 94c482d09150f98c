#include "support/data_path.h"

#include "support/file.h"
#include "support/text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void common_data_path(char path[PATH_MAX], const char *name)
{
    static const char *const places[] = {"share/tribo", TRIBO_DATA_FROM_PROGRAM};

    char          program[PATH_MAX / 2] = "./";
    const ssize_t length                = readlink("/proc/self/exe", program, sizeof program - 1u);
    if (length > 0)
    {
        program[length] = '\0';
    }
    const int folder = (int)(strrchr(program, '/') - program);
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++)
    {
        char resolved[PATH_MAX];
        (void)snprintf(path, PATH_MAX, "%.*s/%s/%s", folder, program, places[i], name);
        if (realpath(path, resolved) != NULL)
        {
            (void)memcpy(path, resolved, PATH_MAX);
            return;
        }
    }
}

char *common_data_named(const char *path, const char *folder, const char *name)
{
    static const char *const endings[] = {"", ".yaml"};
    for (size_t i = 0; i < 2 && !common_file_exists(path) && strchr(name, '/') == NULL; i++)
    {
        char *named = common_text_format("%s/%s%s", folder, name, endings[i]);
        if (named == NULL || common_file_exists(named))
        {
            return named;
        }
        free(named);
    }
    return strdup(path);
}

const char *common_scenario_folder(void)
{
    static char path[PATH_MAX];
    const char *chosen = getenv("TRIBO_SCENARIOS");
    common_data_path(path, "scenarios");
    return chosen != NULL && chosen[0] != '\0' ? chosen : path;
}
