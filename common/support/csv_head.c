#include "support/csv_head.h"

#include "support/csv_field.h"

#include <string.h>
#include <strings.h>

#define PREAMBLE_MAX 1000u ///< most lines above the table

static const char separators[] = ";\t, ";

/// The fields that one separator makes of a line.
typedef struct
{
    size_t fields, numbers;
} line_t;

bool common_csv_line_is_comment(const char *line)
{
    line += strspn(line, " \t");
    return common_csv_line_ends(line) || line[0] == '#' || line[0] == '%' || (line[0] == '/' && line[1] == '/');
}

/// Returns where a line's names begin. The line may be a comment, because NumPy's savetxt writes such headers.
static const char *names_of(const char *line)
{
    return line + strspn(line, "#% ");
}

static line_t split(const char *line, char separator)
{
    line_t             found = {.fields = 0};
    common_csv_field_t field = {.is_last = common_csv_line_ends(line)};
    while (!field.is_last && common_csv_take_field(&line, separator, &field) == NULL)
    {
        found.fields++;
        found.numbers += common_csv_field_is_number(&field) ? 1u : 0u;
    }
    return found;
}

static bool has(const char *line, char separator, const char *name)
{
    common_csv_field_t field = {.is_last = common_csv_line_ends(line)};
    while (!field.is_last && common_csv_take_field(&line, separator, &field) == NULL)
    {
        if (common_csv_field_is(&field, name))
        {
            return true;
        }
    }
    return false;
}

/// Returns true if at least one column is required by name and the line has all of these.
static bool has_all(const char *line, char separator, const common_csv_column_t *columns, size_t count)
{
    size_t named = 0;
    for (size_t i = 0; i < count; i++)
    {
        const bool is_named = !columns[i].optional && columns[i].or_else == 0 && columns[i].name[0] != '#';
        named += is_named ? 1u : 0u;
        if (is_named && !has(names_of(line), separator, columns[i].name))
        {
            return false;
        }
    }
    return named > 0;
}

/// Returns the possible separators: the one that a line of `sep=` gives, or all.
static const char *choices(const common_csv_head_t *head, char given[2])
{
    given[0] = head->separator;
    given[1] = '\0';
    return head->separator != '\0' ? given : separators;
}

static bool find_names(common_csv_head_t *head, const char *text, const common_csv_column_t *columns, size_t count)
{
    char        given[2];
    const char *line = text;
    for (size_t i = 0; i < PREAMBLE_MAX && *line != '\0'; i++, line = common_csv_next_line(line))
    {
        for (const char *separator = choices(head, given); *separator != '\0'; separator++)
        {
            if (has_all(line, *separator, columns, count))
            {
                *head = (common_csv_head_t){*separator, names_of(line), common_csv_next_line(line)};
                return true;
            }
        }
    }
    return false;
}

/// Returns the first line from here on that is not a comment.
static const char *skip_comments(const char *line)
{
    while (*line != '\0' && common_csv_line_is_comment(line))
    {
        line = common_csv_next_line(line);
    }
    return line;
}

/// Returns true if at least half of the fields, and at least two, are numbers, and the next line has as many fields.
static bool is_row(const char *line, char separator, line_t *row)
{
    *row             = split(line, separator);
    const char *next = skip_comments(common_csv_next_line(line));
    return row->fields >= 2 && row->numbers >= 2 && 2 * row->numbers >= row->fields &&
           (*next == '\0' || split(next, separator).fields == row->fields);
}

/// Finds the first row of numbers, and the separator that makes the most of its fields numbers. Null if there is none.
static const char *first_row(common_csv_head_t *head, const char *text, line_t *row)
{
    char        given[2];
    const char *line = skip_comments(text), *found = NULL;
    for (size_t i = 0; found == NULL && i < PREAMBLE_MAX && *line != '\0'; i++)
    {
        const char *choice = choices(head, given);
        line_t      best   = {.fields = 0}, one;
        char        by     = '\0';
        for (; *choice != '\0'; choice++)
        {
            const bool is_one = is_row(line, *choice, &one);
            if (is_one && (best.fields == 0 || one.numbers * best.fields > best.numbers * one.fields))
            {
                best = one;
                by   = *choice;
            }
        }
        if (by != '\0')
        {
            head->separator = by;
            *row            = best;
            found           = line;
        }
        line = skip_comments(common_csv_next_line(line));
    }
    return found;
}

/// Returns the line of names above the rows: the highest of the lines directly above that have no number and at most one
/// field more or less.
static const char *names_above(const char *text, const char *rows, char separator, size_t fields)
{
    const char *found = NULL;
    for (const char *line = text; line < rows; line = common_csv_next_line(line))
    {
        const char  *names   = names_of(line);
        const line_t one     = split(names, separator);
        const bool   is_some = one.numbers == 0 && one.fields + 1 >= fields && one.fields <= fields + 1;
        found                = is_some ? (found != NULL ? found : names) : NULL;
    }
    return found;
}

/// Returns the separator that splits a line of names into the most fields.
static char separator_of(const char *line)
{
    char   best = ' ';
    size_t most = 1;
    for (const char *separator = separators; *separator != '\0'; separator++)
    {
        const size_t fields = split(line, *separator).fields;
        if (fields > most && (*separator != ' ' || most == 1))
        {
            most = fields;
            best = *separator;
        }
    }
    return best;
}

void common_csv_find_head(common_csv_head_t *head, const char *text, const common_csv_column_t *columns, size_t count)
{
    line_t row;
    *head                  = (common_csv_head_t){'\0', NULL, text};
    const char *const hint = text + (text[0] == '"' ? 1 : 0);
    if (strncasecmp(hint, "sep=", 4) == 0 && hint[4] != '\0')
    {
        head->separator = hint[4];
        text            = common_csv_next_line(text);
    }
    if (find_names(head, text, columns, count))
    {
        return;
    }
    const char *rows = first_row(head, text, &row);
    if (rows != NULL)
    {
        head->names = names_above(text, rows, head->separator, row.fields);
        head->rows  = rows;
        return;
    }
    const char *line = skip_comments(text);
    line             = *line != '\0' ? line : text;
    head->separator  = head->separator != '\0' ? head->separator : separator_of(names_of(line));
    head->names      = names_of(line);
    head->rows       = common_csv_next_line(line);
}
