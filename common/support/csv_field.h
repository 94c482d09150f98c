/// The fields of a line of a CSV file or of a log.

#ifndef COMMON_CSV_FIELD_H
#define COMMON_CSV_FIELD_H

#include <stdbool.h>
#include <stddef.h>

typedef struct
{
    const char *text;      ///< without quotes and blanks around it
    size_t      length;    ///< of the text; doubled quotes are still doubled
    const char *start;     ///< where it begins in its line
    bool        is_quoted; ///< in its line
    bool        is_last;   ///< in its line
} common_csv_field_t;

/// Takes the field at `*next` and moves `*next` to the one after it, or to the line's end. A separator of ' ' is any number of blanks.
/// Null, or what is wrong with a quoted field, with `*next` where that is.
const char *common_csv_take_field(const char **next, char separator, common_csv_field_t *field);

/// True if the field's text is `name`.
bool common_csv_field_is(const common_csv_field_t *field, const char *name);

/// True if it looks like a number, with a point or a comma.
bool common_csv_field_is_number(const common_csv_field_t *field);

/// True at a line's end: a newline, with or without a carriage return, or the end of the text.
bool common_csv_line_ends(const char *p);

/// The beginning of the next line, or the end of the text.
const char *common_csv_next_line(const char *p);

#endif
