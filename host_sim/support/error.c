#include "support/error.h"

#include <stdarg.h>
#include <stdio.h>

bool sim_error_set(sim_error_t *error, const char *format, ...)
{
    if (error->text[0] == '\0')
    {
        va_list args;
        va_start(args, format);
        (void)vsnprintf(error->text, sizeof error->text, format, args);
        va_end(args);
    }
    return false;
}
