// bits SCENARIO.yaml...: the digest of each run, as the playground's core has it, but compiled for this host and with tribo-sim's library.

#include "core.h"
#include "support/file.h"

#include <inttypes.h>
#include <stdio.h>

int main(int count, char **paths)
{
    for (int i = 1; i < count; i++)
    {
        common_error_t error = {""};
        char          *text  = common_file_read(paths[i], 1u << 20, &error);
        if (text == NULL || !playground_play(text, false))
        {
            (void)fprintf(stderr, "%s: %s%s\n", paths[i], error.text, playground_complaint());
            return 1;
        }
        (void)printf("%016" PRIx64 "\n", playground_digest());
    }
    return 0;
}
