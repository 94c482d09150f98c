#include "support/csv.h"

#include "support/file.h"
#include "support/number.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// State of the reader. Fields are unquoted and terminated in place.
typedef struct
{
    const char                *name;
    const common_csv_column_t *columns;
    size_t                     count; ///< of columns
    common_error_t            *error;
    bool                       is_log;
    char                       separator;
    char                      *next; ///< the next byte to read
    char                      *line_start;
    size_t                     line;

    size_t fields;                        ///< of the header
    size_t place[COMMON_CSV_COLUMNS_MAX]; ///< by column: its field, from 1; 0: none
} reader_t;

typedef struct
{
    char  *text;
    size_t line, position; ///< where it starts, from 1
    bool   is_last;        ///< in its line
} field_t;

/// Blanks around a field; a separating tab is not a blank.
static const char *blanks(const reader_t *reader)
{
    return reader->separator == ' ' ? "" : reader->separator == '\t' ? " " : " \t";
}

static bool complain(const reader_t *reader, size_t position, const char *what)
{
    return common_error_set(reader->error, "%s:%zu:%zu: %s", reader->name, reader->line, position, what);
}

/// Removes the quotes of a field at `*p`, in place, and moves `*p` past the last one. Returns the text's new end, or null.
static char *unquote(char **p)
{
    char *out = (*p)++;
    while (**p != '\0' && **p != '\n' && (**p != '"' || (*p)[1] == '"'))
    {
        *p += (**p == '"') ? 1 : 0;
        *out++ = *(*p)++;
    }
    if (**p != '"')
    {
        return NULL;
    }
    (*p)++;
    return out;
}

static bool read_field(reader_t *reader, field_t *field)
{
    char *p       = reader->next + strspn(reader->next, blanks(reader));
    char *end     = NULL;
    char  stops[] = {reader->separator, '\n', '\0'};
    *field        = (field_t){.text = p, .line = reader->line, .position = (size_t)(p - reader->line_start) + 1};
    if (*p == '"')
    {
        end = unquote(&p);
        if (end == NULL)
        {
            return complain(reader, field->position, "a quote is opened and not closed in its line");
        }
        p += strspn(p, blanks(reader));
    }
    else
    {
        p += strcspn(p, stops);
        end = (p > field->text && *p == '\n' && p[-1] == '\r') ? p - 1 : p;
        while (end > field->text && strchr(blanks(reader), end[-1]) != NULL) // a text has no zero byte
        {
            end--;
        }
    }
    p += (p[0] == '\r' && p[1] == '\n') ? 1 : 0;
    if (*p != reader->separator && *p != '\n' && *p != '\0')
    {
        return complain(reader, (size_t)(p - reader->line_start) + 1, "text after a quoted field");
    }
    field->is_last = *p != reader->separator;
    reader->next   = (*p != '\0') ? p + 1 : p;
    *end           = '\0';
    if (field->is_last)
    {
        reader->line++;
        reader->line_start = reader->next;
    }
    return true;
}

/// True if a header's field is the column `name`, by name or, in a log, by number.
static bool is_column(const reader_t *reader, const char *name, const char *text)
{
    return strcmp(text, name) == 0 ||
           (reader->is_log && name[0] == '#' && strtoul(name + 1, NULL, 10) == reader->fields);
}

static bool read_header(reader_t *reader)
{
    field_t field = {.is_last = false};
    while (!field.is_last)
    {
        if (!read_field(reader, &field))
        {
            return false;
        }
        reader->fields++;
        for (size_t i = 0; i < reader->count; i++)
        {
            const bool is_it = is_column(reader, reader->columns[i].name, field.text);
            if (is_it && reader->place[i] != 0)
            {
                return common_error_set(reader->error,
                                        "%s:1:%zu: column %s is there twice",
                                        reader->name,
                                        field.position,
                                        field.text);
            }
            reader->place[i] = is_it ? reader->fields : reader->place[i];
        }
    }
    for (size_t i = 0; i < reader->count; i++)
    {
        if (reader->place[i] == 0 && !reader->columns[i].optional)
        {
            const bool is_one = !reader->is_log && reader->fields == 1;
            return common_error_set(reader->error,
                                    "%s:1:1: no column is named %s%s",
                                    reader->name,
                                    reader->columns[i].name,
                                    is_one ? "; columns are separated by commas here, and there is one alone" : "");
        }
    }
    return true;
}

/// Room for as many rows as there are lines left.
static bool allocate(common_csv_t *csv, const reader_t *reader)
{
    size_t rows = 1;
    for (const char *p = strchr(reader->next, '\n'); p != NULL; p = strchr(p + 1, '\n'))
    {
        rows++;
    }
    csv->positions = malloc(rows * sizeof *csv->positions);
    bool ok        = csv->positions != NULL;
    for (size_t i = 0; ok && i < reader->count; i++)
    {
        csv->values[i] = (reader->place[i] != 0) ? malloc(rows * sizeof *csv->values[i]) : NULL;
        ok             = reader->place[i] == 0 || csv->values[i] != NULL;
    }
    return ok || common_error_set(reader->error, "out of memory");
}

/// Takes the number of a column.
static bool take_number(const reader_t *reader, const field_t *field, size_t column, double *value)
{
    char *comma = (reader->separator != ',') ? strchr(field->text, ',') : NULL;
    if (comma != NULL && strchr(field->text, '.') == NULL)
    {
        *comma = '.';
    }
    const common_csv_column_t *spec      = &reader->columns[column];
    const double               max       = (spec->max > 0.0) ? spec->max : COMMON_CSV_NUMBER_MAX;
    const char                *complaint = common_number_parse(field->text, value);
    char                       outside[64];
    (void)snprintf(outside, sizeof outside, "is outside %g to %g", -max, max);
    if (complaint == NULL && fabs(*value) > max)
    {
        complaint = outside;
    }
    return complaint == NULL || common_error_set(reader->error,
                                                 "%s:%zu:%zu: %s: '%.40s' %s",
                                                 reader->name,
                                                 field->line,
                                                 field->position,
                                                 spec->name,
                                                 field->text,
                                                 complaint);
}

/// The places of a number that has been read: all that are written, and those behind the point.
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

/// Takes a field's number for the columns that use it.
static bool take_field(common_csv_t *csv, const reader_t *reader, const field_t *field, size_t number)
{
    for (size_t i = 0; i < reader->count; i++)
    {
        if (reader->place[i] == number && csv->values[i] != NULL)
        {
            csv->positions[csv->rows] = (i == 0) ? field->position : csv->positions[csv->rows];
            const bool ok             = take_number(reader, field, i, &csv->values[i][csv->rows]);
            if (ok && i == 0)
            {
                note_places(csv, field->text);
            }
            return ok;
        }
    }
    return true;
}

static bool read_row(common_csv_t *csv, reader_t *reader)
{
    field_t field             = {.is_last = false};
    size_t  fields            = 0;
    csv->positions[csv->rows] = 1;
    while (!field.is_last)
    {
        if (!read_field(reader, &field))
        {
            return false;
        }
        if (++fields > reader->fields)
        {
            return common_error_set(reader->error,
                                    "%s:%zu:%zu: more fields than the header's %zu",
                                    reader->name,
                                    field.line,
                                    field.position,
                                    reader->fields);
        }
        if (!take_field(csv, reader, &field, fields))
        {
            return false;
        }
    }
    csv->rows++;
    return fields == reader->fields || common_error_set(reader->error,
                                                        "%s:%zu:%zu: %zu fields, the header has %zu",
                                                        reader->name,
                                                        field.line,
                                                        field.position,
                                                        fields,
                                                        reader->fields);
}

/// The separator of a log's first line.
static char find_separator(const char *line)
{
    static const char separators[] = ",;\t";
    size_t            most         = 0;
    char              best         = ' ';
    for (const char *separator = separators; *separator != '\0'; separator++)
    {
        size_t times  = 0;
        bool   quoted = false;
        for (const char *p = line; *p != '\0' && *p != '\n'; p++)
        {
            quoted = quoted != (*p == '"');
            times += (!quoted && *p == *separator) ? 1u : 0u;
        }
        // Decimal commas may outnumber semicolons, so any other separator present beats the comma.
        if (times > 0 && (times > most || best == ','))
        {
            most = times;
            best = *separator;
        }
    }
    return best;
}

/// Leaves one blank between the fields of each line, none at its ends.
static void squeeze_blanks(char *text)
{
    char *out = text;
    for (const char *p = text; *p != '\0'; p++)
    {
        const bool is_blank = *p == ' ' || *p == '\t';
        const bool is_kept  = out > text && out[-1] != '\n' && strchr(" \t\r\n", p[1]) == NULL;
        if (!is_blank)
        {
            *out++ = *p;
        }
        else if (is_kept)
        {
            *out++ = ' ';
        }
    }
    *out = '\0';
}

/// Counts the fields of a log without a header and places the columns by number.
static bool count_fields(reader_t *reader, size_t length)
{
    reader->fields = 1;
    for (size_t i = 0; i < length; i++)
    {
        reader->fields += (reader->next[i] == reader->separator) ? 1u : 0u;
    }
    for (size_t i = 0; i < reader->count; i++)
    {
        const common_csv_column_t *spec   = &reader->columns[i];
        const size_t               number = (spec->name[0] == '#') ? strtoul(spec->name + 1, NULL, 10) : 0;
        reader->place[i]                  = (number <= reader->fields) ? number : 0;
        if (reader->place[i] == 0 && !spec->optional)
        {
            return common_error_set(reader->error,
                                    "%s:1:1: no header, so that no column is %s: there are #1 to #%zu",
                                    reader->name,
                                    spec->name,
                                    reader->fields);
        }
    }
    return true;
}

static bool is_numbers(const char *line)
{
    return line[0] != '\0' && strspn(line, "+-.,;\t 0123456789eE") >= strcspn(line, "\r\n");
}

/// Skips lines of `#` before the header. The last one is the header itself if numbers follow it.
static void skip_comments(reader_t *reader)
{
    const char *end = strchr(reader->next, '\n');
    while (reader->next[0] == '#' && end != NULL && !is_numbers(end + 1))
    {
        reader->next       = reader->next + (end + 1 - reader->next);
        reader->line_start = reader->next;
        reader->line++;
        end = strchr(reader->next, '\n');
    }
}

static bool read_all(common_csv_t *csv, reader_t *reader)
{
    if (reader->next[strspn(reader->next, " \t\r\n")] == '\0')
    {
        return complain(reader, 1, "the file is empty");
    }
    if (reader->is_log)
    {
        skip_comments(reader);
        reader->separator = find_separator(reader->next);
        reader->next += strspn(reader->next, "# "); // NumPy's savetxt writes such headers
        if (reader->separator == ' ')
        {
            squeeze_blanks(reader->next);
        }
    }
    const size_t length     = strcspn(reader->next, "\r\n");
    const bool   headerless = reader->is_log && is_numbers(reader->next);
    const bool   ok         = headerless ? count_fields(reader, length) : read_header(reader);
    csv->first_line         = reader->line; // a header has been read
    if (!ok || !allocate(csv, reader))
    {
        return false;
    }
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
    }
    return csv->rows > 0 || complain(reader, 1, "no rows after the header");
}

static bool parse(common_csv_t              *csv,
                  char                      *text,
                  const char                *name,
                  const common_csv_column_t *columns,
                  size_t                     count,
                  bool                       is_log,
                  common_error_t            *error)
{
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

bool common_csv_parse(common_csv_t              *csv,
                      char                      *text,
                      const char                *name,
                      const common_csv_column_t *columns,
                      size_t                     count,
                      common_error_t            *error)
{
    return parse(csv, text, name, columns, count, false, error);
}

bool common_csv_parse_log(common_csv_t              *csv,
                          char                      *text,
                          const char                *name,
                          const common_csv_column_t *columns,
                          size_t                     count,
                          common_error_t            *error)
{
    return parse(csv, text, name, columns, count, true, error);
}

bool common_csv_read(common_csv_t              *csv,
                     const char                *path,
                     const common_csv_column_t *columns,
                     size_t                     count,
                     common_error_t            *error)
{
    char      *text = common_file_read(path, COMMON_CSV_BYTES_MAX, error);
    const bool ok   = text != NULL && parse(csv, text, path, columns, count, false, error);
    free(text);
    return ok;
}

bool common_csv_read_log(common_csv_t              *csv,
                         const char                *path,
                         const common_csv_column_t *columns,
                         size_t                     count,
                         common_error_t            *error)
{
    char      *text = common_file_read(path, COMMON_CSV_BYTES_MAX, error);
    const bool ok   = text != NULL && parse(csv, text, path, columns, count, true, error);
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
    // Row and line numbers correspond: no field spans lines and no line is skipped.
    return common_error_set(error, "%s:%zu:%zu: %s", csv->name, row + csv->first_line, csv->positions[row], what.text);
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
    const double first = floor(log10(fabs(number))); // place of the first digit; far down for 0
    return 0.5 * pow(10.0, fmax(-csv->decimals, first + 1.0 - csv->digits));
}

void common_csv_free(common_csv_t *csv)
{
    for (size_t i = 0; i < COMMON_CSV_COLUMNS_MAX; i++)
    {
        free(csv->values[i]);
    }
    free(csv->positions);
    *csv = (common_csv_t){.rows = 0};
}
