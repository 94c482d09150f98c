// Reader of the golden vectors: a header line, then rows of numbers.

#ifndef TESTS_SUPPORT_CSV_H
#define TESTS_SUPPORT_CSV_H

#include <stdbool.h>
#include <stdio.h>

#define CSV_COLUMNS_MAX 32

typedef struct
{
    FILE  *file;
    int    columns;
    int    rows; // read so far
    double value[CSV_COLUMNS_MAX];
} csv_t;

/// Opens `name` of tests/golden or its vectors.tar.xz, and fails the test unless its header line is `header`.
void csv_open(csv_t *csv, const char *name, const char *header);

/// Reads one row into `value`; false at the end, where the file is closed.
bool csv_next(csv_t *csv);

#endif
