/// Finds where the table of a recorded log begins: below a preamble of any lines, with or without names, with any separator.

#ifndef COMMON_CSV_HEAD_H
#define COMMON_CSV_HEAD_H

#include "support/csv.h"

typedef struct
{
    char        separator;
    const char *names; ///< the line of names; null: there is none
    const char *rows;  ///< the line after the names, or the first line of numbers
} common_csv_head_t;

/// Finds the first line with all required names; otherwise the line of names above the first numbers. A first line of
/// `sep=;` gives the separator, as in files from Excel.
void common_csv_find_head(common_csv_head_t *head, const char *text, const common_csv_column_t *columns, size_t count);

/// Returns true for an empty line, and for one that begins with #, % or //.
bool common_csv_line_is_comment(const char *line);

#endif
