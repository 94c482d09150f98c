// columns SCENARIO.yaml [q31]: a run's columns as tribo-sim's runner has them, without the rounding of trace.csv: a line of names, then
// the doubles of each column.

#include "core.h"
#include "support/file.h"

#include <stdio.h>

int main(int count, char **arguments)
{
    common_error_t error = {""};
    char          *text  = count >= 2 ? common_file_read(arguments[1], 1u << 20, &error) : NULL;
    if (text == NULL || !playground_play(text, count > 2))
    {
        (void)fprintf(stderr, "%s%s\n", error.text, playground_complaint());
        return 1;
    }
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
