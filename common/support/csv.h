/// Reads named columns of numbers from a CSV file, strictly.
///
/// The first line names the columns; every other line has as many fields. Accepted are CRLF, a byte order mark, quoted
/// fields, spaces around a field, empty lines at the end, a missing last newline, and columns that are not requested.
/// Everything else is an error with file, line and column (the position in the line, in bytes, from 1). So is a last number
/// that the end of the file has cut: it ends in a point, or has fewer digits behind the point or in the exponent than the 20
/// numbers above it, which are alike.
///
/// Recorded logs are read as loggers write them. The table may begin below other lines, and lines of units may follow its
/// names. Empty lines, lines that begin with #, % or //, and words after the last row are skipped. The separator is `;`,
/// tab, `,` or blanks: the one that a first line of `sep=;` gives, or that finds the names, or that makes the rows numbers.
/// Decimal commas are accepted in quotes, and where the comma is not the separator. Without a header, columns go by number.
/// Several requested columns may be the same one of the file. Broken rows are left out and counted, at most one in twenty.

#ifndef COMMON_CSV_H
#define COMMON_CSV_H

#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>

#define COMMON_CSV_COLUMNS_MAX 8u          ///< most columns of one call
#define COMMON_CSV_BYTES_MAX   (1u << 30u) ///< largest file
#define COMMON_CSV_NUMBER_MAX  1e30        ///< largest number; keeps differences, slopes and floats finite
#define COMMON_CSV_UNIT_MAX    16u         ///< bytes of a unit that is kept

typedef struct
{
    const char *name; ///< in a recorded log, "#3" is the third column
    bool        optional;
    size_t      or_else; ///< number of the column that may stand in for this one; 0: none
    const char *why;     ///< what requires it: the beginning of the message if it is missing; null: none
    double      max;     ///< largest magnitude of a number; 0: COMMON_CSV_NUMBER_MAX
} common_csv_column_t;

typedef struct
{
    const char *name; ///< name of the file, for messages
    size_t      rows;
    double     *values[COMMON_CSV_COLUMNS_MAX]; ///< for each requested column; null: optional and missing
    size_t     *lines, *positions;              ///< for each row its line, and the first requested column's place in it
    size_t      left_out;                       ///< number of broken rows of a log
    char       *left_out_first;                 ///< message about the first of them; null: none is left out
    char        units
        [COMMON_CSV_COLUMNS_MAX]
        [COMMON_CSV_UNIT_MAX]; ///< what may be a log's units: in brackets or behind the last `_` or blank of a name, or from
                               ///< the line below; otherwise ""
    int digits, decimals;      ///< most significant digits of a number, and most digits behind the point
} common_csv_t;

/// Reads `count` columns of a file, or of a recorded log. On failure nothing is left to free.
bool common_csv_read(common_csv_t              *csv,
                     const char                *path,
                     const common_csv_column_t *columns,
                     size_t                     count,
                     bool                       is_log,
                     common_error_t            *error);

/// Reads `count` columns from text, which is changed in place; `name` stands for the file in messages.
bool common_csv_parse(common_csv_t              *csv,
                      char                      *text,
                      const char                *name,
                      const common_csv_column_t *columns,
                      size_t                     count,
                      bool                       is_log,
                      common_error_t            *error);

/// Reports an error at the first requested column of a row: "FILE:LINE:COLUMN: " and the text. Always returns false.
bool common_csv_complain(const common_csv_t *csv, size_t row, common_error_t *error, const char *format, ...);

/// Returns false, with the error, if the numbers of the first requested column do not rise from row to row.
bool common_csv_check_rising(const common_csv_t *csv, const char *name, common_error_t *error);

/// Returns how far a number of the first requested column may be rounded: half a unit of its last place. The file's longest
/// number gives the number of places, because a writer may omit zeros.
double common_csv_rounding(const common_csv_t *csv, double number);

void common_csv_free(common_csv_t *csv);

#endif
