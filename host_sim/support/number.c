#include "support/number.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const char *skip_digits(const char *p)
{
    while (*p >= '0' && *p <= '9')
    {
        p++;
    }
    return p;
}

static const char *skip_sign(const char *p)
{
    return (*p == '+' || *p == '-') ? p + 1 : p;
}

/// [sign] digits [. digits] [e [sign] digits], with a digit before or after the point.
static bool is_decimal(const char *text)
{
    const char *whole = skip_sign(text);
    const char *p     = skip_digits(whole);
    size_t      count = (size_t)(p - whole);
    if (*p == '.')
    {
        const char *end = skip_digits(p + 1);
        count += (size_t)(end - (p + 1));
        p = end;
    }
    if (count == 0)
    {
        return false;
    }
    if (*p == 'e' || *p == 'E')
    {
        const char *exponent = skip_sign(p + 1);
        p                    = skip_digits(exponent);
        if (p == exponent)
        {
            return false;
        }
    }
    return *p == '\0';
}

static bool is_not_finite_word(const char *text)
{
    static const char *const words[] = {"nan", ".nan", "inf", ".inf", "infinity"};

    const char *p = skip_sign(text);
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
    {
        if (strcasecmp(p, words[i]) == 0)
        {
            return true;
        }
    }
    return false;
}

const char *sim_number_parse(const char *text, double *value)
{
    if (is_not_finite_word(text))
    {
        return "is not a finite number";
    }
    if (!is_decimal(text))
    {
        return "is not a number";
    }
    // The program never calls setlocale, so strtod's point is '.' wherever it runs.
    *value = strtod(text, NULL);
    return isfinite(*value) ? NULL : "is too large for a number";
}

const char *sim_number_parse_whole(const char *text, uint64_t *value)
{
    const char *end = skip_digits(text);
    if (end == text || *end != '\0')
    {
        return "is not a whole number of 0 or more";
    }
    errno  = 0;
    *value = strtoull(text, NULL, 10);
    return errno == 0 ? NULL : "is too large for a whole number";
}
