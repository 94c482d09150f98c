/// Holds one message for the user: the fault and its place (FILE:LINE:COLUMN or --set key=value).
///
/// Functions that can fail fill in the error and return false (or null); the program prints the error and ends. The first
/// error is kept.

#ifndef COMMON_ERROR_H
#define COMMON_ERROR_H

#include <stdarg.h>
#include <stdbool.h>

typedef struct
{
    char text[36864]; ///< one line, safe to show on a terminal; empty: no error
} common_error_t;

/// Writes the message, with control characters as \n or \x1b, unless there is one already. Always returns false. Two paths of
/// maximum length fit, even with every character escaped.
bool common_error_set(common_error_t *error, const char *format, ...);
bool common_error_set_list(common_error_t *error, const char *format, va_list args);

#endif
