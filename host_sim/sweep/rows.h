/// The CSV file that a sweep's rows go into, one after the other: what is there after a kill stays, all but the row that was being
/// written. Every row begins with the study's id and its own number, so that rows of another study are not taken for this one's.

#ifndef SIM_ROWS_H
#define SIM_ROWS_H

#include "support/error.h"

#include <stdint.h>
#include <stdio.h>

#define SIM_SHARDS_MAX 100000u

/// Which of a study's rows a file holds: those whose number divided by `count` leaves `index`.
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

/// Opens the file to go on with, or makes it; nobody else may be writing it. `header` is its first line. `rows` of the study.
bool sim_rows_open(sim_rows_t *file, const char *header, uint64_t rows, sim_error_t *error);

/// Writes "id,number," and the text as the next row, and hands it to the system.
bool sim_rows_append(sim_rows_t *file, const char *text, sim_error_t *error);

bool sim_rows_close(sim_rows_t *file, sim_error_t *error);

/// The text of a file that must be complete, with a 0 in place of each end of line; to be freed. `*first` is its first row.
char *sim_rows_read(const sim_rows_t *file, const char *header, uint64_t rows, char **first, sim_error_t *error);

/// Splits a row at its commas, in place, and unquotes; returns how many fields there are, of which `max` are stored.
size_t sim_rows_split(char *row, char **field, size_t max);

/// Appends a field, quoted if it must be.
void sim_rows_write_field(FILE *stream, const char *text);

#endif
