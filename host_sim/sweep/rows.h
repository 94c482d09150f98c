/// The CSV file of a sweep's rows, in order. After a kill all but the row being written is kept. Every row begins with the
/// study's id and its own number, so that rows of another study are detected.

#ifndef COMMON_ROWS_H
#define COMMON_ROWS_H

#include "support/error.h"

#include <stdint.h>
#include <stdio.h>

#define SIM_SHARDS_MAX 100000u

/// The rows that a file holds: those whose number modulo `count` is `index`.
typedef struct
{
    uint64_t index, count; ///< 0, 1: all
} sim_shard_t;

uint64_t sim_shard_rows(const sim_shard_t *shard, uint64_t rows);

typedef struct
{
    FILE       *stream;
    const char *path;
    uint32_t    id;
    sim_shard_t shard;
    uint64_t    rows; ///< in the file
} sim_rows_t;

/// Opens the file to append, or creates it. Fails if another process writes it. `header` is the first line, `rows` the study's.
bool sim_rows_open(sim_rows_t *file, const char *header, uint64_t rows, common_error_t *error);

/// Writes "id,number," and the text as the next row, and flushes it to the system.
bool sim_rows_append(sim_rows_t *file, const char *text, common_error_t *error);

bool sim_rows_close(sim_rows_t *file, common_error_t *error);

/// The text of a complete file, with a 0 in place of each end of line; to be freed. `*first` is its first row.
char *sim_rows_read(const sim_rows_t *file, const char *header, uint64_t rows, char **first, common_error_t *error);

/// Splits a row at its commas, in place, and unquotes. Returns the number of fields; stores at most `max`.
size_t sim_rows_split(char *row, char **field, size_t max);

/// Appends a field, quoted if necessary.
void sim_rows_write_field(FILE *stream, const char *text);

#endif
