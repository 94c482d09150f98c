#include "support/csv.h"

#include "support/file.h"
#include "support/number.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define NOT_WANTED SIZE_MAX

/// Where the reader is. Fields are unquoted and ended in place.
typedef struct
{
    const char  *path;
    char        *next; ///< the next byte to read
    char        *line_start;
    size_t       line;
    sim_error_t *error;
} reader_t;

typedef struct
{
    char  *text;
    size_t position; ///< in its line, from 1
    bool   last;     ///< in its line
} field_t;

/// Which wanted column each field of a line feeds.
typedef struct
{
    size_t *column;
    size_t  fields;
} layout_t;

static bool is_space(char c)
{
    return c == ' ' || c == '\t';
}

static bool at_line_end(const char *p)
{
    return *p == '\0' || *p == '\n' || (*p == '\r' && p[1] == '\n');
}

static void next_line(reader_t *reader, char *end)
{
    reader->next       = end;
    reader->line_start = end;
    reader->line++;
}

/// A quoted field from its first quote on: unquotes it in place; returns what follows the last quote, or null.
static char *unquote(reader_t *reader, field_t *field)
{
    char *out   = field->text;
    char *quote = field->text;
    for (char *p = quote + 1; *p != '\0' && *p != '\n'; p++)
    {
        if (*p == '"')
        {
            if (p[1] != '"')
            {
                *out = '\0';
                return p + 1;
            }
            p++;
        }
        *out++ = *p;
    }
    (void)sim_error_set(reader->error,
                        "%s:%zu:%zu: a quote is opened and not closed in its line",
                        reader->path,
                        reader->line,
                        field->position);
    return NULL;
}

/// Ends a field at its separator and steps over that.
static bool end_field(reader_t *reader, field_t *field, char *end)
{
    if (!(*end == ',' || at_line_end(end)))
    {
        return sim_error_set(reader->error,
                             "%s:%zu:%zu: text after a quoted field",
                             reader->path,
                             reader->line,
                             (size_t)(end - reader->line_start) + 1);
    }
    field->last = *end != ',';
    char *after = end;
    if (*after == '\r')
    {
        after++;
    }
    if (*after != '\0')
    {
        after++;
    }
    const bool new_line = field->last;
    *end                = '\0';
    reader->next        = after;
    if (new_line)
    {
        next_line(reader, after);
    }
    return true;
}

static bool read_field(reader_t *reader, field_t *field)
{
    char *p = reader->next;
    while (is_space(*p))
    {
        p++;
    }
    field->text     = p;
    field->position = (size_t)(p - reader->line_start) + 1;
    if (*p == '"')
    {
        char *end = unquote(reader, field);
        while (end != NULL && is_space(*end))
        {
            end++;
        }
        return end != NULL && end_field(reader, field, end);
    }
    while (*p != ',' && !at_line_end(p))
    {
        p++;
    }
    char *trimmed = p;
    while (trimmed > field->text && is_space(trimmed[-1]))
    {
        trimmed--;
    }
    const bool ok = end_field(reader, field, p);
    *trimmed      = '\0';
    return ok;
}

static bool is_blank_rest(const char *p)
{
    return p[strspn(p, " \t\r\n")] == '\0';
}

static bool is_blank_line(const char *p)
{
    return at_line_end(p + strspn(p, " \t"));
}

static size_t find_wanted(const char *name, const sim_csv_column_t *wanted, size_t count)
{
    for (size_t i = 0; i < count; i++)
    {
        if (strcmp(name, wanted[i].name) == 0)
        {
            return i;
        }
    }
    return NOT_WANTED;
}

/// Takes the header's fields; `found` counts how often each wanted column came.
static bool read_names(reader_t *reader, layout_t *layout, const sim_csv_column_t *wanted, size_t count, bool *found)
{
    const size_t line  = reader->line;
    field_t      field = {.last = false};
    while (!field.last)
    {
        if (!read_field(reader, &field))
        {
            return false;
        }
        const size_t column = find_wanted(field.text, wanted, count);
        if (column != NOT_WANTED && found[column])
        {
            return sim_error_set(reader->error,
                                 "%s:%zu:%zu: column %s is there twice",
                                 reader->path,
                                 line,
                                 field.position,
                                 field.text);
        }
        if (column != NOT_WANTED)
        {
            found[column] = true;
        }
        size_t *larger = realloc(layout->column, (layout->fields + 1) * sizeof *larger);
        if (larger == NULL)
        {
            return sim_error_set(reader->error, "out of memory");
        }
        layout->column                   = larger;
        layout->column[layout->fields++] = column;
    }
    return true;
}

static bool read_header(reader_t *reader, layout_t *layout, const sim_csv_column_t *wanted, size_t count, bool *found)
{
    if (is_blank_rest(reader->next))
    {
        return sim_error_set(reader->error, "%s:1:1: the file is empty", reader->path);
    }
    if (!read_names(reader, layout, wanted, count, found))
    {
        return false;
    }
    for (size_t i = 0; i < count; i++)
    {
        if (!found[i] && !wanted[i].optional)
        {
            return sim_error_set(reader->error, "%s:1:1: no column is named %s", reader->path, wanted[i].name);
        }
    }
    return true;
}

/// Takes the number of a wanted column.
static bool take_number(const reader_t *reader, const field_t *field, size_t line, const char *name, double *value)
{
    const char *complaint = sim_number_parse(field->text, value);
    return complaint == NULL || sim_error_set(reader->error,
                                              "%s:%zu:%zu: %s: '%.40s' %s",
                                              reader->path,
                                              line,
                                              field->position,
                                              name,
                                              field->text,
                                              complaint);
}

static bool read_row(reader_t *reader, const layout_t *layout, const sim_csv_column_t *wanted, sim_csv_t *csv)
{
    const size_t line   = reader->line;
    size_t       fields = 0;
    field_t      field  = {.last = false};
    while (!field.last)
    {
        if (!read_field(reader, &field))
        {
            return false;
        }
        if (fields >= layout->fields)
        {
            return sim_error_set(reader->error,
                                 "%s:%zu:%zu: more fields than the header's %zu",
                                 reader->path,
                                 line,
                                 field.position,
                                 layout->fields);
        }
        const size_t column = layout->column[fields++];
        if (column == 0)
        {
            csv->positions[csv->rows] = field.position;
        }
        if (column != NOT_WANTED &&
            !take_number(reader, &field, line, wanted[column].name, &csv->values[column][csv->rows]))
        {
            return false;
        }
    }
    if (fields < layout->fields)
    {
        return sim_error_set(reader->error,
                             "%s:%zu:%zu: %zu fields, the header has %zu",
                             reader->path,
                             line,
                             field.position,
                             fields,
                             layout->fields);
    }
    csv->lines[csv->rows++] = line;
    return true;
}

/// Room for as many rows as there are lines left.
static bool allocate(sim_csv_t *csv, const char *rest, size_t count, const bool *found)
{
    size_t rows = 1;
    for (const char *p = rest; *p != '\0'; p++)
    {
        rows += (*p == '\n') ? 1u : 0u;
    }
    csv->lines     = malloc(rows * sizeof *csv->lines);
    csv->positions = malloc(rows * sizeof *csv->positions);
    bool ok        = csv->lines != NULL && csv->positions != NULL;
    for (size_t i = 0; ok && i < count; i++)
    {
        csv->values[i] = found[i] ? malloc(rows * sizeof *csv->values[i]) : NULL;
        ok             = !found[i] || csv->values[i] != NULL;
    }
    return ok;
}

static bool read_rows(reader_t *reader, const layout_t *layout, const sim_csv_column_t *wanted, sim_csv_t *csv)
{
    while (!is_blank_rest(reader->next))
    {
        if (is_blank_line(reader->next))
        {
            return sim_error_set(reader->error, "%s:%zu:1: an empty line between rows", reader->path, reader->line);
        }
        if (!read_row(reader, layout, wanted, csv))
        {
            return false;
        }
    }
    if (csv->rows == 0)
    {
        return sim_error_set(reader->error, "%s:%zu:1: no rows after the header", reader->path, reader->line);
    }
    return true;
}

bool sim_csv_read(sim_csv_t *csv, const char *path, const sim_csv_column_t *wanted, size_t count, sim_error_t *error)
{
    *csv        = (sim_csv_t){0};
    char *bytes = sim_file_read(path, SIM_CSV_BYTES_MAX, error);
    if (bytes == NULL)
    {
        return false;
    }
    reader_t reader                     = {.path = path, .next = bytes, .line_start = bytes, .line = 1, .error = error};
    layout_t layout                     = {0};
    bool     found[SIM_CSV_COLUMNS_MAX] = {false};
    bool     ok                         = read_header(&reader, &layout, wanted, count, found);
    if (ok && !allocate(csv, reader.next, count, found))
    {
        ok = sim_error_set(error, "out of memory");
    }
    ok = ok && read_rows(&reader, &layout, wanted, csv);
    free(layout.column);
    free(bytes);
    if (!ok)
    {
        sim_csv_free(csv);
    }
    return ok;
}

void sim_csv_free(sim_csv_t *csv)
{
    for (size_t i = 0; i < SIM_CSV_COLUMNS_MAX; i++)
    {
        free(csv->values[i]);
    }
    free(csv->lines);
    free(csv->positions);
    *csv = (sim_csv_t){0};
}
