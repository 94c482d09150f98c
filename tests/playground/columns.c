// columns SCENARIO.yaml [q31], or columns joint NUMBER...: a run by the playground's core, compiled for this host and with tribo-sim's library. Prints a line with its
// digest, a line of its columns' names, and the doubles of each column, without the rounding of trace.csv.

#include "core.h"
#include "joint.h"
#include "support/file.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool play_scenario(int count, char **arguments, common_error_t *error)
{
    char *text = count >= 2 ? common_file_read(arguments[1], 1u << 20, error) : NULL;
    return text != NULL && playground_play(text, count > 2);
}

static bool play_joint(char **numbers)
{
    double *settings = (double *)(void *)playground_room(JOINT_SETTINGS * sizeof(double));
    for (int i = 0; settings != NULL && i < JOINT_SETTINGS; i++)
    {
        settings[i] = strtod(numbers[i], NULL);
    }
    return settings != NULL && playground_play_joint(settings);
}

int main(int count, char **arguments)
{
    common_error_t error    = {""};
    const bool     is_joint = count == 2 + JOINT_SETTINGS && strcmp(arguments[1], "joint") == 0;
    if (!(is_joint ? play_joint(arguments + 2) : play_scenario(count, arguments, &error)))
    {
        (void)fprintf(stderr, "%s%s\n", error.text, playground_complaint());
        return 1;
    }
    (void)printf("%016" PRIx64 "\n", playground_digest());
    for (unsigned i = 0; i < playground_column_count(); i++)
    {
        (void)printf("%s%s", i > 0 ? "," : "", playground_column_name(i));
    }
    (void)putchar('\n');
    for (unsigned i = 0; i < playground_column_count(); i++)
    {
        (void)fwrite(playground_column(i), sizeof(double), playground_row_count(), stdout);
    }
    return 0;
}
