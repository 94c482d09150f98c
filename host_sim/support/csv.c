#include "support/csv.h"

#include "support/file.h"
#include "support/number.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// Where the reader is. Fields are unquoted and ended in place.
typedef struct
{
    const char             *name;
    const sim_csv_column_t *wanted;
    size_t                  count; ///< of wanted columns
    sim_error_t            *error;
    char                   *next; ///< the next byte to read
    char                   *line_start;
    size_t                  line;

    size_t fields;                     ///< of the header
    size_t place[SIM_CSV_COLUMNS_MAX]; ///< by wanted column: its field, from 1; 0: none
} reader_t;

typedef struct
{
    char  *text;
    size_t line, position; ///< where it starts, from 1
    bool   is_last;        ///< in its line
} field_t;

static bool is_blank(char c)
{
    return c == ' ' || c == '\t';
}

static bool complain(const reader_t *reader, size_t position, const char *what)
{
    return sim_error_set(reader->error, "%s:%zu:%zu: %s", reader->name, reader->line, position, what);
}

/// Takes the quotes off a field at `*p`, in place; then `*p` is behind the last one. Returns the text's new end, or null.
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
    char *p   = reader->next + strspn(reader->next, " \t");
    char *end = NULL;
    *field    = (field_t){.text = p, .line = reader->line, .position = (size_t)(p - reader->line_start) + 1};
    if (*p == '"')
    {
        end = unquote(&p);
        if (end == NULL)
        {
            return complain(reader, field->position, "a quote is opened and not closed in its line");
        }
        p += strspn(p, " \t");
    }
    else
    {
        p += strcspn(p, ",\n");
        end = (p > field->text && *p == '\n' && p[-1] == '\r') ? p - 1 : p;
        while (end > field->text && is_blank(end[-1]))
        {
            end--;
        }
    }
    p += (p[0] == '\r' && p[1] == '\n') ? 1 : 0;
    if (*p != ',' && *p != '\n' && *p != '\0')
    {
        return complain(reader, (size_t)(p - reader->line_start) + 1, "text after a quoted field");
    }
    field->is_last = *p != ',';
    reader->next   = (*p != '\0') ? p + 1 : p;
    *end           = '\0';
    if (field->is_last)
    {
        reader->line++;
        reader->line_start = reader->next;
    }
    return true;
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
            const bool is_it = strcmp(field.text, reader->wanted[i].name) == 0;
            if (is_it && reader->place[i] != 0)
            {
                return sim_error_set(reader->error,
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
        if (reader->place[i] == 0 && !reader->wanted[i].optional)
        {
            return sim_error_set(reader->error, "%s:1:1: no column is named %s", reader->name, reader->wanted[i].name);
        }
    }
    return true;
}

/// Room for as many rows as there are lines left.
static bool allocate(sim_csv_t *csv, const reader_t *reader)
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
    return ok || sim_error_set(reader->error, "out of memory");
}

/// Takes the number of a wanted column.
static bool take_number(const reader_t *reader, const field_t *field, size_t column, double *value)
{
    const sim_csv_column_t *wanted    = &reader->wanted[column];
    const double            max       = (wanted->max > 0.0) ? wanted->max : SIM_CSV_NUMBER_MAX;
    const char             *complaint = sim_number_parse(field->text, value);
    char                    outside[64];
    (void)snprintf(outside, sizeof outside, "is outside %g to %g", -max, max);
    if (complaint == NULL && fabs(*value) > max)
    {
        complaint = outside;
    }
    return complaint == NULL || sim_error_set(reader->error,
                                              "%s:%zu:%zu: %s: '%.40s' %s",
                                              reader->name,
                                              field->line,
                                              field->position,
                                              wanted->name,
                                              field->text,
                                              complaint);
}

/// Takes what a field of a row feeds.
static bool take_field(sim_csv_t *csv, const reader_t *reader, const field_t *field, size_t number)
{
    for (size_t i = 0; i < reader->count; i++)
    {
        if (reader->place[i] == number && csv->values[i] != NULL)
        {
            csv->positions[csv->rows] = (i == 0) ? field->position : csv->positions[csv->rows];
            return take_number(reader, field, i, &csv->values[i][csv->rows]);
        }
    }
    return true;
}

static bool read_row(sim_csv_t *csv, reader_t *reader)
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
            return sim_error_set(reader->error,
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
    return fields == reader->fields || sim_error_set(reader->error,
                                                     "%s:%zu:%zu: %zu fields, the header has %zu",
                                                     reader->name,
                                                     field.line,
                                                     field.position,
                                                     fields,
                                                     reader->fields);
}

static bool read_all(sim_csv_t *csv, reader_t *reader)
{
    if (reader->next[strspn(reader->next, " \t\r\n")] == '\0')
    {
        return complain(reader, 1, "the file is empty");
    }
    if (!read_header(reader) || !allocate(csv, reader))
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

bool sim_csv_parse(sim_csv_t              *csv,
                   char                   *text,
                   const char             *name,
                   const sim_csv_column_t *wanted,
                   size_t                  count,
                   sim_error_t            *error)
{
    reader_t reader =
        {.name = name, .wanted = wanted, .count = count, .error = error, .next = text, .line_start = text, .line = 1};
    *csv          = (sim_csv_t){.name = name};
    const bool ok = read_all(csv, &reader);
    if (!ok)
    {
        sim_csv_free(csv);
    }
    return ok;
}

bool sim_csv_read(sim_csv_t *csv, const char *path, const sim_csv_column_t *wanted, size_t count, sim_error_t *error)
{
    char      *text = sim_file_read(path, SIM_CSV_BYTES_MAX, error);
    const bool ok   = text != NULL && sim_csv_parse(csv, text, path, wanted, count, error);
    free(text);
    return ok;
}

bool sim_csv_complain(const sim_csv_t *csv, size_t row, sim_error_t *error, const char *format, ...)
{
    sim_error_t what = {""};
    va_list     args;
    va_start(args, format);
    (void)sim_error_set_list(&what, format, args);
    va_end(args);
    // Row 0 is in line 2: no field goes over a line's end, and no line is left out.
    return sim_error_set(error, "%s:%zu:%zu: %s", csv->name, row + 2, csv->positions[row], what.text);
}

bool sim_csv_check_rising(const sim_csv_t *csv, const char *name, sim_error_t *error)
{
    const double *x = csv->values[0];
    for (size_t i = 1; i < csv->rows; i++)
    {
        if (!(x[i] > x[i - 1]))
        {
            return sim_csv_complain(csv, i, error, "%s: %.15g does not come after %.15g", name, x[i], x[i - 1]);
        }
    }
    return true;
}

void sim_csv_free(sim_csv_t *csv)
{
    for (size_t i = 0; i < SIM_CSV_COLUMNS_MAX; i++)
    {
        free(csv->values[i]);
    }
    free(csv->positions);
    *csv = (sim_csv_t){.rows = 0};
}
