#include "support/csv_field.h"

#include <string.h>

bool common_csv_line_ends(const char *p)
{
    return p[0] == '\0' || p[0] == '\n' || (p[0] == '\r' && (p[1] == '\n' || p[1] == '\0'));
}

const char *common_csv_next_line(const char *p)
{
    p += strcspn(p, "\n");
    return *p == '\n' ? p + 1 : p;
}

/// Returns whether c is a blank; a tab that separates is not.
static bool is_blank(char c, char separator)
{
    return c == ' ' || (c == '\t' && separator != '\t');
}

static const char *skip_blanks(const char *p, char separator)
{
    while (is_blank(*p, separator))
    {
        p++;
    }
    return p;
}

static bool separates(char c, char separator)
{
    return c == separator || (separator == ' ' && c == '\t');
}

/// Returns the end of a quoted text: its last quote, or the line's end.
static const char *closing_quote(const char *p)
{
    while (!common_csv_line_ends(p) && (*p != '"' || p[1] == '"'))
    {
        p += *p == '"' ? 2 : 1;
    }
    return p;
}

const char *common_csv_take_field(const char **next, char separator, common_csv_field_t *field)
{
    const char *p = skip_blanks(*next, separator);
    *field        = (common_csv_field_t){.text = p, .start = p, .is_quoted = *p == '"'};
    if (field->is_quoted)
    {
        field->text = p + 1;
        p           = closing_quote(field->text);
        if (*p != '"')
        {
            *next = field->start;
            return "a quote is opened and not closed in its line";
        }
        field->length = (size_t)(p - field->text);
        p++;
    }
    else
    {
        while (!common_csv_line_ends(p) && !separates(*p, separator))
        {
            p++;
        }
        field->length = (size_t)(p - field->text);
        while (field->length > 0 && is_blank(field->text[field->length - 1], separator))
        {
            field->length--;
        }
    }
    const char *after = skip_blanks(p, separator);
    field->is_last    = common_csv_line_ends(after);
    const bool is_end = field->is_last || separates(*after, separator) || (separator == ' ' && after > p);
    *next             = field->is_last || separator == ' ' || !is_end ? after : after + 1;
    return is_end ? NULL : "text after a quoted field";
}

bool common_csv_field_is(const common_csv_field_t *field, const char *name)
{
    size_t i = 0;
    for (; i < field->length && *name != '\0'; i++, name++)
    {
        i += field->is_quoted && field->text[i] == '"' ? 1u : 0u; // skips the first of two quotes
        if (field->text[i] != *name)
        {
            return false;
        }
    }
    return i == field->length && *name == '\0';
}

bool common_csv_field_is_number(const common_csv_field_t *field)
{
    const char *p = field->text, *end = field->text + field->length;
    size_t      digits = 0, marks = 0, powers = 0;
    p += p < end && (*p == '+' || *p == '-') ? 1 : 0;
    for (; p < end; p++)
    {
        const bool is_power = (*p == 'e' || *p == 'E') && digits > 0 && powers == 0 && p + 1 < end;
        if (is_power)
        {
            p += p[1] == '+' || p[1] == '-' ? 1 : 0;
            powers++;
        }
        else if (*p == '.' || *p == ',')
        {
            marks++;
        }
        else if (*p >= '0' && *p <= '9')
        {
            digits++;
        }
        else
        {
            return false;
        }
    }
    return digits > 0 && marks <= 1 && end[-1] != ',';
}
