#include "support/data_path.h"

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
