// columns SCENARIO.yaml [q31]: a run by the playground's core, compiled for this host and with tribo-sim's library. Prints a line with its
// digest, a line of its columns' names, and the doubles of each column, without the rounding of trace.csv.

#include "core.h"
#include "support/file.h"

#include <inttypes.h>
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
