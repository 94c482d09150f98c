#include "support/csv.h"

#include "support/csv_field.h"
#include "support/csv_head.h"
#include "support/file.h"
#include "support/number.h"
#include "support/text.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NUMBER_MAX     64u ///< characters of a number
#define LEFT_OUT       20u ///< one in so many rows of a log may be broken and left out
#define NAME_MAX_SHOWN 64u
#define NAMES_SHOWN    400u
#define ALIKE_ROWS     20u ///< numbers of one form before a shorter one at the end of the file counts as cut

/// How the numbers of a column are written.
typedef struct
{
    size_t decimals, exponent; ///< digits behind the point, and of the exponent
    size_t rows;               ///< numbers so far, while all are of this form
} form_t;

/// State of the reader.
typedef struct
{
    const char                *name;
    const common_csv_column_t *columns;
    size_t                     count; ///< number of columns
    common_error_t            *error;
    bool                       is_log;
    char                       separator;
    const char                *next; ///< the next byte to read
    const char                *line_start;
    size_t                     line;
    const char                *names; ///< where the header's names begin

    size_t fields;                        ///< fields of the header
    size_t row_fields;                    ///< fields of a row; 0: no row has been read
    size_t place[COMMON_CSV_COLUMNS_MAX]; ///< for each column its field, from 1; 0: none
    form_t forms[COMMON_CSV_COLUMNS_MAX];
} reader_t;

static bool complain(const reader_t *reader, size_t position, const char *what)
{
    return common_error_set(reader->error, "%s:%zu:%zu: %s", reader->name, reader->line, position, what);
}

static size_t position_of(const reader_t *reader, const char *p)
{
    return (size_t)(p - reader->line_start) + 1;
}

static void begin_line(reader_t *reader, const char *line)
{
    for (const char *p = reader->line_start; p < line; p++)
    {
        reader->line += *p == '\n' ? 1u : 0u;
    }
    reader->next       = line;
    reader->line_start = line;
}

static bool take_field(reader_t *reader, common_csv_field_t *field)
{
    const char *what = common_csv_take_field(&reader->next, reader->separator, field);
    return what == NULL || complain(reader, position_of(reader, reader->next), what);
}

/// Returns true if a header's field is the column `name`, by name or, in a log, by number.
static bool is_column(const reader_t *reader, const char *name, const common_csv_field_t *field)
{
    return common_csv_field_is(field, name) ||
           (reader->is_log && name[0] == '#' && strtoul(name + 1, NULL, 10) == reader->fields);
}

/// Copies a field's text without quotes, in small letters if `small`.
static void copy_name(const common_csv_field_t *field, bool small, char word[NAME_MAX_SHOWN])
{
    const size_t length = field->length < NAME_MAX_SHOWN ? field->length : NAME_MAX_SHOWN - 1;
    for (size_t i = 0; i < length; i++)
    {
        const char c = field->text[i];
        word[i]      = small && c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c;
    }
    word[length] = '\0';
}

/// Returns the distance of a field's name from the requested one, regardless of case. A name that only adds to the other, e.g. a
/// unit, is near.
static size_t distance(const char *requested, const common_csv_field_t *field)
{
    char small[NAME_MAX_SHOWN], word[NAME_MAX_SHOWN];
    copy_name(&(common_csv_field_t){.text = requested, .length = strlen(requested)}, true, small);
    copy_name(field, true, word);
    const size_t shorter = strlen(word) < strlen(small) ? strlen(word) : strlen(small);
    return shorter > 0 && strncmp(small, word, shorter) == 0 ? 1 : common_text_distance(small, word);
}

/// Returns true if a column has been found in this field.
static bool is_taken(const reader_t *reader, size_t number)
{
    for (size_t i = 0; i < reader->count; i++)
    {
        if (reader->place[i] == number)
        {
            return true;
        }
    }
    return false;
}

/// Returns the first column that is required and has neither a field nor a stand-in; null if there is none.
static const common_csv_column_t *find_missing(const reader_t *reader)
{
    for (size_t i = 0; i < reader->count; i++)
    {
        const common_csv_column_t *column = &reader->columns[i];
        if (!column->optional && reader->place[i] == 0 && (column->or_else == 0 || reader->place[column->or_else] == 0))
        {
            return column;
        }
    }
    return NULL;
}

/// Reports a missing column, with the nearest name and all names of the file.
static bool complain_of_missing(const reader_t *reader, const common_csv_column_t *column)
{
    const char *const  name               = column->name;
    char               names[NAMES_SHOWN] = "", nearest[NAME_MAX_SHOWN] = "";
    size_t             used = 0, best = common_text_too_far(name);
    common_csv_field_t field = {.is_last = false};
    const char        *next  = reader->names;
    best = best < strlen(name) ? best : strlen(name); // a name that differs in each letter is not meant
    for (size_t number = 1; !field.is_last && common_csv_take_field(&next, reader->separator, &field) == NULL; number++)
    {
        char word[NAME_MAX_SHOWN];
        copy_name(&field, false, word);
        const size_t apart = distance(name, &field);
        if (apart < best && !is_taken(reader, number))
        {
            best = apart;
            memcpy(nearest, word, sizeof nearest);
        }
        if (used + strlen(word) + sizeof ", ..." < sizeof names)
        {
            used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", used > 0 ? ", " : "", word);
        }
    }
    return common_error_set(reader->error,
                            "%s%s:%zu:1: no column is named %s%s%s%s; %s %s",
                            column->why != NULL ? column->why : "",
                            reader->name,
                            reader->line,
                            name,
                            nearest[0] != '\0' ? ", did you mean " : "",
                            nearest,
                            nearest[0] != '\0' ? "?" : "",
                            reader->fields == 1 ? "the only column is" : "there are",
                            names);
}

/// Keeps the unit of a field: the whole field or, of a name, the text in brackets at its end or behind its last `_` or blank.
static void take_unit(char unit[COMMON_CSV_UNIT_MAX], const common_csv_field_t *field, bool is_name)
{
    const char *begin = field->text, *end = field->text + field->length;
    const bool  ends = field->length > 2 && (end[-1] == ']' || end[-1] == ')');
    if (ends)
    {
        const char open = end[-1] == ']' ? '[' : '(';
        for (const char *p = begin; p < end; p++)
        {
            begin = *p == open ? p + 1 : begin;
        }
        end--;
    }
    for (const char *p = begin; is_name && !ends && p < end; p++)
    {
        begin = *p == '_' || *p == ' ' ? p + 1 : begin;
    }
    const size_t length = (size_t)(end - begin);
    if ((ends || !is_name || begin > field->text) && length < COMMON_CSV_UNIT_MAX)
    {
        memcpy(unit, begin, length);
        unit[length] = '\0';
    }
}

/// Keeps the units in a line below the names.
static void take_units(common_csv_t *csv, const reader_t *reader, const char *line)
{
    common_csv_field_t field = {.is_last = common_csv_line_ends(line)};
    for (size_t number = 1; !field.is_last; number++)
    {
        (void)common_csv_take_field(&line, reader->separator, &field);
        for (size_t i = 0; i < reader->count; i++)
        {
            if (reader->place[i] == number)
            {
                take_unit(csv->units[i], &field, false);
            }
        }
    }
}

/// Finds the columns by the names in a line.
static bool read_header(common_csv_t *csv, reader_t *reader)
{
    common_csv_field_t field = {.is_last = false};
    while (!field.is_last)
    {
        if (!take_field(reader, &field))
        {
            return false;
        }
        reader->fields++;
        for (size_t i = 0; i < reader->count; i++)
        {
            const bool is_it = is_column(reader, reader->columns[i].name, &field);
            if (is_it && reader->place[i] != 0)
            {
                return common_error_set(reader->error,
                                        "%s:%zu:%zu: column %s appears twice",
                                        reader->name,
                                        reader->line,
                                        position_of(reader, field.start),
                                        reader->columns[i].name);
            }
            reader->place[i] = is_it ? reader->fields : reader->place[i];
            if (is_it)
            {
                take_unit(csv->units[i], &field, true);
            }
        }
    }
    const common_csv_column_t *missing = find_missing(reader);
    if (missing == NULL || reader->is_log)
    {
        return missing == NULL || complain_of_missing(reader, missing);
    }
    return common_error_set(reader->error,
                            "%s:1:1: no column is named %s%s",
                            reader->name,
                            missing->name,
                            reader->fields == 1 ? "; columns must be separated by commas, and there is only one" : "");
}

/// Allocates room for as many rows as there are lines left.
static bool allocate(common_csv_t *csv, const reader_t *reader)
{
    size_t rows = 1;
    for (const char *p = strchr(reader->next, '\n'); p != NULL; p = strchr(p + 1, '\n'))
    {
        rows++;
    }
    csv->positions = malloc(rows * sizeof *csv->positions);
    csv->lines     = malloc(rows * sizeof *csv->lines);
    bool ok        = csv->positions != NULL && csv->lines != NULL;
    for (size_t i = 0; ok && i < reader->count; i++)
    {
        csv->values[i] = (reader->place[i] != 0) ? malloc(rows * sizeof *csv->values[i]) : NULL;
        ok             = reader->place[i] == 0 || csv->values[i] != NULL;
    }
    return ok || common_error_set(reader->error, "out of memory");
}

/// Copies a field's text for the parser of numbers: a comma that is not the separator becomes a point.
static void copy_number(const reader_t *reader, const common_csv_field_t *field, char text[NUMBER_MAX])
{
    const size_t length = field->length < NUMBER_MAX ? field->length : NUMBER_MAX - 1;
    memcpy(text, field->text, length);
    text[length]      = '\0';
    char *const comma = reader->separator != ',' || (reader->is_log && field->is_quoted) ? strchr(text, ',') : NULL;
    if (comma != NULL && strchr(text, '.') == NULL)
    {
        *comma = '.';
    }
}

/// Parses the number of a column.
static bool take_number(const reader_t           *reader,
                        const common_csv_field_t *field,
                        size_t                    column,
                        const char               *text,
                        double                   *value)
{
    const common_csv_column_t *spec      = &reader->columns[column];
    const double               max       = (spec->max > 0.0) ? spec->max : COMMON_CSV_NUMBER_MAX;
    const char                *complaint = common_number_parse_sample(text, value);
    char                       outside[64];
    (void)snprintf(outside, sizeof outside, "is outside %g to %g", -max, max);
    if (complaint == NULL && fabs(*value) > max)
    {
        complaint = outside;
    }
    return complaint == NULL || common_error_set(reader->error,
                                                 "%s:%zu:%zu: %s: '%.40s' %s",
                                                 reader->name,
                                                 reader->line,
                                                 position_of(reader, field->start),
                                                 spec->name,
                                                 text,
                                                 complaint);
}

/// Notes how many digits a number is written with, in all and behind the point.
static void note_places(common_csv_t *csv, const char *text)
{
    int  digits = 0, decimals = 0;
    bool behind = false;
    for (; *text != '\0' && *text != 'e' && *text != 'E'; text++)
    {
        const bool is_digit = *text >= '0' && *text <= '9';
        digits += is_digit && (digits > 0 || *text != '0') ? 1 : 0;
        decimals += is_digit && behind ? 1 : 0;
        behind = behind || *text == '.';
    }
    decimals -= *text != '\0' ? (int)strtol(text + 1, NULL, 10) : 0;
    csv->digits   = digits > csv->digits ? digits : csv->digits;
    csv->decimals = decimals > csv->decimals ? decimals : csv->decimals;
}

static form_t form_of(const char *text)
{
    const char *point = strchr(text, '.'), *power = strpbrk(text, "eE");
    return (form_t){.decimals = point != NULL ? strspn(point + 1, "0123456789") : 0u,
                    .exponent = power != NULL ? strlen(power + 1 + strspn(power + 1, "+-")) : 0u,
                    .rows     = 1u};
}

static void note_form(form_t *form, const char *text)
{
    const form_t one     = form_of(text);
    const bool   is_like = one.decimals == form->decimals && one.exponent == form->exponent;
    const size_t before  = is_like ? form->rows : 0u;
    *form                = one;
    form->rows           = before + 1u;
}

/// Returns true if the file ends within this number: behind a point, or before the form of the numbers above is complete.
static bool is_cut(const form_t *form, const common_csv_field_t *field, const char *text)
{
    const form_t one = form_of(text);
    return field->length > 0 && field->text[field->length] == '\0' &&
           (text[strlen(text) - 1] == '.' ||
            (form->rows >= ALIKE_ROWS && (one.decimals < form->decimals || one.exponent < form->exponent)));
}

/// Takes a field's number for each column that uses the field.
static bool take_values(common_csv_t *csv, reader_t *reader, const common_csv_field_t *field, size_t number)
{
    char text[NUMBER_MAX] = "";
    for (size_t i = 0; i < reader->count; i++)
    {
        if (reader->place[i] != number)
        {
            continue;
        }
        copy_number(reader, field, text);
        if (!take_number(reader, field, i, text, &csv->values[i][csv->rows]))
        {
            return false;
        }
        if (is_cut(&reader->forms[i], field, text))
        {
            return common_error_set(reader->error,
                                    "%s:%zu:%zu: %s: the file ends in the middle of the number '%.40s'",
                                    reader->name,
                                    reader->line,
                                    position_of(reader, field->start),
                                    reader->columns[i].name,
                                    text);
        }
        note_form(&reader->forms[i], text);
        if (i == 0)
        {
            csv->positions[csv->rows] = position_of(reader, field->start);
            note_places(csv, text);
        }
    }
    return true;
}

/// Returns whether a row may have so many fields. All rows of a log may have one less than the header, if they omit a column of
/// comments.
static bool may_have(reader_t *reader, size_t fields)
{
    size_t last = 0;
    for (size_t i = 0; i < reader->count; i++)
    {
        last = reader->place[i] > last ? reader->place[i] : last;
    }
    if (reader->row_fields == 0 &&
        (fields == reader->fields || (reader->is_log && fields + 1 == reader->fields && last <= fields)))
    {
        reader->row_fields = fields;
    }
    return fields == reader->row_fields;
}

static bool read_row(common_csv_t *csv, reader_t *reader)
{
    common_csv_field_t field  = {.is_last = false};
    size_t             fields = 0;
    csv->positions[csv->rows] = 1;
    csv->lines[csv->rows]     = reader->line;
    while (!field.is_last)
    {
        if (!take_field(reader, &field))
        {
            return false;
        }
        if (++fields > reader->fields && !(reader->is_log && field.length == 0 && field.is_last))
        {
            return common_error_set(reader->error,
                                    "%s:%zu:%zu: more fields than the header's %zu",
                                    reader->name,
                                    reader->line,
                                    position_of(reader, field.start),
                                    reader->fields);
        }
        if (!take_values(csv, reader, &field, fields))
        {
            return false;
        }
    }
    fields -= fields > reader->fields ? 1 : 0; // an empty field at the end does not count
    if (!may_have(reader, fields))
    {
        return common_error_set(reader->error,
                                "%s:%zu:%zu: %zu fields, the %s %zu",
                                reader->name,
                                reader->line,
                                position_of(reader, field.start),
                                fields,
                                reader->row_fields == 0 || reader->row_fields == reader->fields ? "header has"
                                                                                                : "other rows have",
                                reader->row_fields == 0 ? reader->fields : reader->row_fields);
    }
    csv->rows++;
    return true;
}

/// Reads the rows of a file in which every row must be right. It may end in empty lines.
static bool read_rows(common_csv_t *csv, reader_t *reader)
{
    while (reader->next[strspn(reader->next, " \t\r\n")] != '\0')
    {
        if (reader->next[strspn(reader->next, " \t\r")] == '\n')
        {
            return complain(reader, 1, "an empty line between rows");
        }
        if (!read_row(csv, reader))
        {
            return false;
        }
        begin_line(reader, common_csv_next_line(reader->next));
    }
    return csv->rows > 0 || complain(reader, 1, "no rows after the header");
}

/// What the columns have in a line.
typedef enum
{
    LINE_OF_NUMBERS, ///< at least one
    LINE_OF_NANS,    ///< no number, but nan or inf: a row that has none, not units
    LINE_OF_WORDS    ///< units then, or words at the end
} line_t;

/// Returns whether a program has written this for a number that it did not have: nan, -inf and their like.
static bool is_nan(const reader_t *reader, const common_csv_field_t *field)
{
    char  text[NUMBER_MAX];
    char *end;
    copy_number(reader, field, text);
    return !isfinite(strtod(text, &end)) && end > text && *end == '\0';
}

static line_t kind_of(const reader_t *reader, const char *line)
{
    line_t             kind  = LINE_OF_WORDS;
    common_csv_field_t field = {.is_last = false};
    for (size_t number = 1; !field.is_last; number++)
    {
        if (common_csv_take_field(&line, reader->separator, &field) != NULL)
        {
            return LINE_OF_NUMBERS; // a quote is broken
        }
        for (size_t i = 0; i < reader->count; i++)
        {
            if (reader->place[i] == number && common_csv_field_is_number(&field))
            {
                return LINE_OF_NUMBERS;
            }
            kind = reader->place[i] == number && is_nan(reader, &field) ? LINE_OF_NANS : kind;
        }
    }
    return kind;
}

/// Refuses a log with too many broken rows; otherwise keeps the message about the first. `words` is the message about
/// a row of words, for a log that has no other rows.
static bool end_log(common_csv_t *csv, const reader_t *reader, const common_error_t *first, const common_error_t *words)
{
    const size_t rows = csv->rows + csv->left_out;
    if (rows == 0)
    {
        return words->text[0] != '\0' ? common_error_set(reader->error, "%s, and no row has numbers", words->text)
                                      : complain(reader, 1, "no rows after the header");
    }
    if (csv->rows == 0 || csv->left_out * LEFT_OUT > rows)
    {
        return csv->left_out == 1 ? common_error_set(reader->error, "%s", first->text)
                                  : common_error_set(reader->error,
                                                     "%s, and %zu more rows of %zu are broken",
                                                     first->text,
                                                     csv->left_out - 1,
                                                     rows);
    }
    csv->left_out_first = csv->left_out > 0 ? common_text_format("%s", first->text) : NULL;
    return csv->left_out == 0 || csv->left_out_first != NULL || common_error_set(reader->error, "out of memory");
}

/// Reads a row. Its error goes to `why`, not to the reader's error.
static bool try_row(common_csv_t *csv, reader_t *reader, common_error_t *why)
{
    common_error_t *const error = reader->error;
    why->text[0]                = '\0';
    reader->error               = why;
    const bool is_good          = read_row(csv, reader);
    reader->error               = error;
    return is_good;
}

/// Reads the rows of a log and leaves out those that are broken. Lines of words above and below the rows do not count.
static bool read_log_rows(common_csv_t *csv, reader_t *reader)
{
    common_error_t first = {""}, one, word = {""};
    size_t         words = 0; // lines since the last row
    size_t         above = 0; // lines above the first row
    for (; *reader->next != '\0'; begin_line(reader, common_csv_next_line(reader->next)))
    {
        if (common_csv_line_is_comment(reader->next))
        {
            continue;
        }
        if (try_row(csv, reader, &one))
        {
            csv->left_out += words;
            words = 0;
            continue;
        }
        const line_t kind    = kind_of(reader, reader->line_start);
        const bool   is_text = kind != LINE_OF_NUMBERS;
        if (kind == LINE_OF_WORDS && csv->rows == 0)
        {
            take_units(csv, reader, reader->line_start);
        }
        if (is_text && csv->rows == 0 && (above++ > 0 || kind == LINE_OF_NANS)) // the first may be a line of units
        {
            (void)common_error_set(&word, "%s", one.text);
        }
        words += is_text && csv->rows > 0 ? 1u : 0u;
        csv->left_out += is_text ? 0u : 1u;
        if (!is_text || csv->rows > 0)
        {
            (void)common_error_set(&first, "%s", one.text); // keeps the first message
        }
    }
    return end_log(csv, reader, &first, &word);
}

/// Finds the columns of a log without a header by their numbers.
static bool count_fields(reader_t *reader)
{
    const char        *next  = reader->next;
    common_csv_field_t field = {.is_last = false};
    while (!field.is_last && common_csv_take_field(&next, reader->separator, &field) == NULL)
    {
        reader->fields++;
    }
    for (size_t i = 0; i < reader->count; i++)
    {
        const common_csv_column_t *spec   = &reader->columns[i];
        const size_t               number = (spec->name[0] == '#') ? strtoul(spec->name + 1, NULL, 10) : 0;
        reader->place[i]                  = (number <= reader->fields) ? number : 0;
    }
    const common_csv_column_t *missing = find_missing(reader);
    return missing == NULL || common_error_set(reader->error,
                                               "%s%s:%zu:1: no header, so no column is named %s; there are #1 to #%zu",
                                               missing->why != NULL ? missing->why : "",
                                               reader->name,
                                               reader->line,
                                               missing->name,
                                               reader->fields);
}

static bool read_log(common_csv_t *csv, reader_t *reader)
{
    common_csv_head_t head;
    const char *const text = reader->next;
    common_csv_find_head(&head, text, reader->columns, reader->count);
    reader->separator = head.separator;
    const char *first = head.names != NULL ? head.names : head.rows;
    while (first > text && first[-1] != '\n')
    {
        first--; // names may stand in a comment
    }
    begin_line(reader, first);
    reader->names = head.names;
    reader->next  = head.names != NULL ? head.names : head.rows;
    if (!(head.names != NULL ? read_header(csv, reader) : count_fields(reader)))
    {
        return false;
    }
    begin_line(reader, head.rows);
    return allocate(csv, reader) && read_log_rows(csv, reader);
}

static bool read_all(common_csv_t *csv, reader_t *reader)
{
    if (reader->next[strspn(reader->next, " \t\r\n")] == '\0')
    {
        return complain(reader, 1, "the file is empty");
    }
    if (reader->is_log)
    {
        return read_log(csv, reader);
    }
    if (!read_header(csv, reader))
    {
        return false;
    }
    begin_line(reader, common_csv_next_line(reader->next));
    return allocate(csv, reader) && read_rows(csv, reader);
}

/// Replaces the carriage returns of a file without newlines: old Macs end lines so.
static void replace_returns(char *text)
{
    char *p = strchr(text, '\n') == NULL ? strchr(text, '\r') : NULL;
    for (; p != NULL; p = strchr(p, '\r'))
    {
        *p = '\n';
    }
}

bool common_csv_parse(common_csv_t              *csv,
                      char                      *text,
                      const char                *name,
                      const common_csv_column_t *columns,
                      size_t                     count,
                      bool                       is_log,
                      common_error_t            *error)
{
    if (is_log)
    {
        replace_returns(text);
    }
    reader_t reader = {.name       = name,
                       .columns    = columns,
                       .count      = count,
                       .error      = error,
                       .is_log     = is_log,
                       .separator  = ',',
                       .next       = text,
                       .line_start = text,
                       .line       = 1};
    *csv            = (common_csv_t){.name = name};
    const bool ok   = read_all(csv, &reader);
    if (!ok)
    {
        common_csv_free(csv);
    }
    return ok;
}

bool common_csv_read(common_csv_t              *csv,
                     const char                *path,
                     const common_csv_column_t *columns,
                     size_t                     count,
                     bool                       is_log,
                     common_error_t            *error)
{
    char      *text = common_file_read(path, COMMON_CSV_BYTES_MAX, error);
    const bool ok   = text != NULL && common_csv_parse(csv, text, path, columns, count, is_log, error);
    free(text);
    return ok;
}

bool common_csv_complain(const common_csv_t *csv, size_t row, common_error_t *error, const char *format, ...)
{
    common_error_t what = {""};
    va_list        args;
    va_start(args, format);
    (void)common_error_set_list(&what, format, args);
    va_end(args);
    return common_error_set(error, "%s:%zu:%zu: %s", csv->name, csv->lines[row], csv->positions[row], what.text);
}

bool common_csv_check_rising(const common_csv_t *csv, const char *name, common_error_t *error)
{
    const double *x = csv->values[0];
    for (size_t i = 1; i < csv->rows; i++)
    {
        if (!(x[i] > x[i - 1]))
        {
            return common_csv_complain(csv, i, error, "%s: %.15g does not come after %.15g", name, x[i], x[i - 1]);
        }
    }
    return true;
}

double common_csv_rounding(const common_csv_t *csv, double number)
{
    const double first = floor(log10(fabs(number))); // place of the first digit; minus infinity for 0
    return 0.5 * pow(10.0, fmax(-csv->decimals, first + 1.0 - csv->digits));
}

void common_csv_free(common_csv_t *csv)
{
    for (size_t i = 0; i < COMMON_CSV_COLUMNS_MAX; i++)
    {
        free(csv->values[i]);
    }
    free(csv->positions);
    free(csv->lines);
    free(csv->left_out_first);
    *csv = (common_csv_t){.rows = 0};
}
