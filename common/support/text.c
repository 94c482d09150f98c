#include "support/text.h"

#include "support/c_locale.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WORD_MAX 255u

char *common_text_format(const char *format, ...)
{
    va_list                 args;
    const common_c_locale_t scope = common_c_locale_begin();
    va_start(args, format);
    const int length = vsnprintf(NULL, 0, format, args);
    va_end(args);
    char *text = (length >= 0) ? malloc((size_t)length + 1) : NULL;
    if (text != NULL)
    {
        va_start(args, format);
        (void)vsnprintf(text, (size_t)length + 1, format, args);
        va_end(args);
    }
    common_c_locale_end(scope);
    return text;
}

char *common_text_quoted(const char *path)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789@%+=:,./-_";
    static const char quote[] = "'\\''"; // ends the quoted text, a quote of its own, and begins it again
    const bool        is_bare = path[0] != '\0' && path[strspn(path, plain)] == '\0';
    char *const       text    = malloc(sizeof "./''" + strlen(path) * (sizeof quote - 1));
    char             *end     = text;
    if (text == NULL)
    {
        return NULL;
    }
    end = stpcpy(end, is_bare ? "" : "'");
    end = stpcpy(end, path[0] == '-' ? "./" : "");
    for (; *path != '\0'; path++)
    {
        const char letter[] = {*path, '\0'};
        end                 = stpcpy(end, *path == '\'' ? quote : letter);
    }
    (void)stpcpy(end, is_bare ? "" : "'");
    return text;
}

static size_t smaller(size_t a, size_t b)
{
    return a < b ? a : b;
}

size_t common_text_distance(const char *a, const char *b)
{
    size_t       row[WORD_MAX + 1];
    const size_t width = strlen(b);
    if (width > WORD_MAX)
    {
        return SIZE_MAX;
    }
    for (size_t j = 0; j <= width; j++)
    {
        row[j] = j;
    }
    for (size_t i = 1; a[i - 1] != '\0'; i++)
    {
        size_t diagonal = row[0];
        row[0]          = i;
        for (size_t j = 1; j <= width; j++)
        {
            const size_t above   = row[j];
            const size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0u : 1u);
            row[j]               = smaller(changed, smaller(above, row[j - 1]) + 1);
            diagonal             = above;
        }
    }
    return row[width];
}

size_t common_text_too_far(const char *word)
{
    const size_t third = strlen(word) / 3;
    return (third > 2 ? third : 2) + 1;
}
