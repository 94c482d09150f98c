#include "support/number.h"

#include "support/c_locale.h"

#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static bool is_not_finite_word(const char *text)
{
    const char *word = text + strspn(text, "+-");
    word += (*word == '.') ? 1 : 0;
    return strcasecmp(word, "nan") == 0 || strcasecmp(word, "inf") == 0 || strcasecmp(word, "infinity") == 0;
}

static const char *parse(const char *text, double *value)
{
    if (is_not_finite_word(text))
    {
        return "is not a finite number";
    }
    // With these characters only, strtod can only read decimal numbers.
    char                   *end   = NULL;
    const common_c_locale_t scope = common_c_locale_begin();
    *value                        = strtod(text, &end);
    common_c_locale_end(scope);
    if (end == text || *end != '\0' || text[strspn(text, "+-.0123456789eE")] != '\0')
    {
        return "is not a number";
    }
    return isfinite(*value) ? NULL : "is too large for a number";
}

/// Returns true if the text is smaller than `least` and not 0, even if strtod rounds it to 0.
static bool is_below(const char *text, double value, double least)
{
    const char *digit = text + strcspn(text, "123456789eE");
    return fabs(value) < least && *digit >= '1' && *digit <= '9';
}

static bool is_tiny(const char *text, double value)
{
    return is_below(text, value, (double)FLT_MIN);
}

bool common_number_is_below(const char *text, double least)
{
    double value;
    return parse(text, &value) == NULL && is_below(text, value, least);
}

const char *common_number_parse(const char *text, double *value)
{
    const char *complaint = parse(text, value);
    return complaint == NULL && is_tiny(text, *value) ? "is too small for a number: 0, or at least 1.2e-38 in size"
                                                      : complaint;
}

const char *common_number_parse_sample(const char *text, double *value)
{
    const char *complaint = parse(text, value);
    *value                = complaint == NULL && is_tiny(text, *value) ? 0.0 : *value;
    return complaint;
}

const char *common_number_parse_whole(const char *text, uint64_t *value)
{
    if (*text == '\0' || text[strspn(text, "0123456789")] != '\0')
    {
        return "is not a whole number of 0 or more";
    }
    errno  = 0;
    *value = strtoull(text, NULL, 10);
    return errno == 0 ? NULL : "is too large for a whole number";
}
