/// Named columns of numbers from a CSV file, read strictly.
///
/// The first line names the columns; every other line has as many fields. Accepted: CRLF, a byte order mark, quoted
/// fields, spaces around a field, empty lines at the end, a missing last newline, columns that are not requested.
/// Everything else is an error with file, line and column (the position in the line, in bytes, from 1).
///
/// Recorded logs are read as loggers write them. The table may begin below other lines, and lines of units may follow its names.
/// Lines that begin with #, % or // are skipped, empty ones too, and words after the last row. The separator is `;`, tab, `,` or blanks:
/// the one that a first line of `sep=;` says, or that finds the names, or that makes the rows numbers. Decimal commas are
/// accepted where the comma is not the separator, and in quotes. Without a header, columns go by number. Several columns that are asked
/// for may be one of the file. Broken rows are left out and counted, one of twenty at most.

#ifndef COMMON_CSV_H
#define COMMON_CSV_H

#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>

#define COMMON_CSV_COLUMNS_MAX 8u          ///< most columns of one call
#define COMMON_CSV_BYTES_MAX   (1u << 30u) ///< of a file
#define COMMON_CSV_NUMBER_MAX  1e30        ///< keeps differences, slopes and floats finite
#define COMMON_CSV_UNIT_MAX    16u         ///< bytes of a unit that is kept

typedef struct
{
    const char *name; ///< "#3" is the third column, in a recorded log
    bool        optional;
    double      max; ///< of a number's magnitude; 0: COMMON_CSV_NUMBER_MAX
} common_csv_column_t;

typedef struct
{
    const char *name; ///< of the file, for messages
    size_t      rows;
    double     *values[COMMON_CSV_COLUMNS_MAX]; ///< by column asked for; null: optional and missing
    size_t     *lines, *positions;              ///< by row: its line, and there the place of the first column asked for
    size_t      left_out;                       ///< broken rows of a log
    char       *left_out_first;                 ///< what is wrong with the first one; null: none is left out
    char        units[COMMON_CSV_COLUMNS_MAX]
              [COMMON_CSV_UNIT_MAX]; ///< of a log, in brackets behind a name or in the line below: else ""
    int digits, decimals;            ///< most significant digits of its numbers, and most behind the point
} common_csv_t;

/// Reads `count` columns of a file, or of a recorded log. On failure nothing is left to free.
bool common_csv_read(common_csv_t              *csv,
                     const char                *path,
                     const common_csv_column_t *columns,
                     size_t                     count,
                     bool                       is_log,
                     common_error_t            *error);

/// The same from text, which is changed in place; `name` stands for the file in messages.
bool common_csv_parse(common_csv_t              *csv,
                      char                      *text,
                      const char                *name,
                      const common_csv_column_t *columns,
                      size_t                     count,
                      bool                       is_log,
                      common_error_t            *error);

/// Reports an error in the first column asked for of a row: "FILE:LINE:COLUMN: " and the rest. Always false.
bool common_csv_complain(const common_csv_t *csv, size_t row, common_error_t *error, const char *format, ...);

/// False if the numbers of the first column asked for do not rise from row to row.
bool common_csv_check_rising(const common_csv_t *csv, const char *name, common_error_t *error);

/// By how much a number of the first column asked for may be off as it is written: half a unit of its last place. The file's longest
/// number says how many places there are, as a writer may leave out zeros.
double common_csv_rounding(const common_csv_t *csv, double number);

void common_csv_free(common_csv_t *csv);

#endif
