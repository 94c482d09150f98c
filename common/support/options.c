#include "support/options.h"

#include <string.h>

static struct
{
    const struct argp_option *option;
    const char               *value;
} given[COMMON_OPTIONS_MAX];

static size_t count;

/// Returns whether a text of NAME=VALUE assigns a {mapping}.
static bool is_mapping(const char *text)
{
    const char *value = text + strcspn(text, "=");
    value += *value == '=' ? 1 : 0;
    return value[strspn(value, " \t\r\n")] == '{';
}

/// Returns whether two values of an option exclude each other.
static bool exclude(const struct argp_option *option, const char *before, const char *value)
{
    return option->arg == NULL || strchr(option->arg, '=') == NULL || before == NULL || value == NULL ||
           (strncmp(before, value, strcspn(value, "=") + 1u) == 0 && !is_mapping(value));
}

bool common_options_add(const struct argp_option *known, int key, const char *value, common_error_t *error)
{
    while (known->name != NULL && known->key != key)
    {
        known++;
    }
    if (known->name == NULL)
    {
        return true;
    }
    for (size_t i = 0; strstr(known->doc, "may be repeated") == NULL && i < count; i++)
    {
        const char *before = given[i].value;
        if (given[i].option == known && exclude(known, before, value))
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
    if (count == COMMON_OPTIONS_MAX)
    {
        return common_error_set(error, "more than %u options", COMMON_OPTIONS_MAX);
    }
    given[count].option  = known;
    given[count++].value = value;
    return true;
}

const struct argp_option *common_options_at(size_t i)
{
    return i < count ? given[i].option : NULL;
}
