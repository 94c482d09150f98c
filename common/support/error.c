#include "support/error.h"

#include "support/c_locale.h"

#include <stdio.h>

/// Returns true for C0, DEL, and C1 in UTF-8 (0xc2 and a byte of 0x80 to 0x9f).
static bool is_control(const unsigned char *byte, unsigned char before)
{
    return *byte < 0x20u || *byte == 0x7fu || (*byte == 0xc2u && byte[1] >= 0x80u && byte[1] <= 0x9fu) ||
           (before == 0xc2u && *byte >= 0x80u && *byte <= 0x9fu);
}

/// Copies `from` with its control characters escaped, as much of it as there is room for.
static void copy_printable(char *to, size_t size, const char *from)
{
    unsigned char before = 0;
    size_t        length = 0;
    for (const unsigned char *p = (const unsigned char *)from; *p != '\0' && length + sizeof "\\x00" <= size; p++)
    {
        const char *format = !is_control(p, before) ? "%c" : *p == '\n' ? "\\n" : "\\x%02x";
        // NOLINTNEXTLINE(clang-diagnostic-format-nonliteral): the format is one of three literals
        length += (size_t)snprintf(to + length, size - length, format, *p);
        before = *p;
    }
    to[length] = '\0';
}

bool common_error_set_list(common_error_t *error, const char *format, va_list args)
{
    char text[sizeof error->text];
    if (error->text[0] == '\0')
    {
        const common_c_locale_t scope = common_c_locale_begin();
        (void)vsnprintf(text, sizeof text, format, args);
        common_c_locale_end(scope);
        copy_printable(error->text, sizeof error->text, text);
    }
    return false;
}

bool common_error_set(common_error_t *error, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    (void)common_error_set_list(error, format, args);
    va_end(args);
    return false;
}
