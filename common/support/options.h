/// What all programs ask of their command lines, which argp reads: an option is given once. One that takes NAME=VALUE is given
/// once for each NAME, but {mappings} add to each other. One whose text says "may be repeated" is given as often as needed.

#ifndef COMMON_OPTIONS_H
#define COMMON_OPTIONS_H

#include "support/error.h"

#include <argp.h>
#include <stddef.h>
#include <string.h>

#define COMMON_OPTIONS_MAX 4096u ///< on a command line

/// The options so far; all zeros at the beginning.
typedef struct
{
    struct
    {
        const struct argp_option *option;
        const char               *value;
    } given[COMMON_OPTIONS_MAX];
    size_t count;
} common_options_t;

/// Returns whether two values of an option exclude each other.
static inline bool common_options_exclude(const struct argp_option *option, const char *before, const char *value)
{
    return option->arg == NULL || strchr(option->arg, '=') == NULL || before == NULL || value == NULL ||
           (strncmp(before, value, strcspn(value, "=") + 1u) == 0 && strstr(value, "={") == NULL);
}

/// Notes the option of `key`, if `known` has it. Returns false with the error filled in if it was given before.
static inline bool common_options_add(common_options_t         *options,
                                      const struct argp_option *known,
                                      int                       key,
                                      const char               *value,
                                      common_error_t           *error)
{
    while (known->name != NULL && known->key != key)
    {
        known++;
    }
    if (known->name == NULL)
    {
        return true;
    }
    for (size_t i = 0; strstr(known->doc, "may be repeated") == NULL && i < options->count; i++)
    {
        const char *before = options->given[i].value;
        if (options->given[i].option == known && common_options_exclude(known, before, value))
        {
            return value == NULL || before == NULL ? common_error_set(error, "--%s is given twice", known->name)
                                                   : common_error_set(error,
                                                                      "--%s %s and --%s %s: only one is expected",
                                                                      known->name,
                                                                      before,
                                                                      known->name,
                                                                      value);
        }
    }
    if (options->count == COMMON_OPTIONS_MAX)
    {
        return common_error_set(error, "more than %u options", COMMON_OPTIONS_MAX);
    }
    options->given[options->count].option  = known;
    options->given[options->count++].value = value;
    return true;
}

#endif
