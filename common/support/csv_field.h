/// Splits a line of a CSV file or of a log into fields.

#ifndef COMMON_CSV_FIELD_H
#define COMMON_CSV_FIELD_H

#include <stdbool.h>
#include <stddef.h>

typedef struct
{
    const char *text;      ///< text without the quotes and blanks around it
    size_t      length;    ///< length of the text; doubled quotes are still doubled
    const char *start;     ///< where the field begins in its line
    bool        is_quoted; ///< the field is quoted
    bool        is_last;   ///< the field is the last one of its line
} common_csv_field_t;

/// Takes the field at `*next` and moves `*next` to the field after it, or to the line's end. The separator ' ' stands for
/// any number of blanks. Returns null, or the fault of a quoted field, with `*next` at its place.
const char *common_csv_take_field(const char **next, char separator, common_csv_field_t *field);

/// Returns true if the field's text is `name`.
bool common_csv_field_is(const common_csv_field_t *field, const char *name);

/// Returns true if the field looks like a number, with a point or a comma.
bool common_csv_field_is_number(const common_csv_field_t *field);

/// Returns true at a line's end: a newline, with or without a carriage return, or the end of the text.
bool common_csv_line_ends(const char *p);

/// Returns the beginning of the next line, or the end of the text.
const char *common_csv_next_line(const char *p);

#endif
