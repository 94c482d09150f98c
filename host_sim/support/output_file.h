/// A file that appears whole or not at all: written beside its place under a temporary name, then renamed. What is no
/// regular file, a device or a pipe, is written to as it is.

#ifndef SIM_OUTPUT_FILE_H
#define SIM_OUTPUT_FILE_H

#include "support/error.h"

#include <stdbool.h>
#include <stdio.h>

typedef struct
{
    FILE *stream;
    char *path;      ///< null for standard output
    char *temporary; ///< null if `path` is written to as it is
} sim_output_file_t;

/// Opens a temporary file beside `path` (beside what it points to, if it is a link), or standard output if `path` is null.
bool sim_output_file_open(sim_output_file_t *file, const char *path, sim_error_t *error);

/// Flushes, checks everything written since the file was opened, and puts the file in its place. On failure nothing is left.
bool sim_output_file_commit(sim_output_file_t *file, sim_error_t *error);

/// From now on a signal that ends the program (SIGINT, SIGTERM, SIGHUP) takes the temporary file with it. For a program's
/// main, as signals are the program's.
void sim_output_file_clean_on_signal(void);

/// Removes the temporary file. Does nothing to a file that is closed already or was never opened (all zero).
void sim_output_file_discard(sim_output_file_t *file);

/// A whole file of one line, in its place or not at all.
bool sim_output_file_write_line(const char *path, const char *line, sim_error_t *error);

/// Removes what an earlier run has written; does nothing if no regular file is there.
bool sim_output_file_remove(const char *path, sim_error_t *error);

/// Flushes standard output and checks everything written to it.
bool sim_output_flush(sim_error_t *error);

/// Creates the folder `path` and those above it that are missing.
bool sim_output_folder_create(const char *path, sim_error_t *error);

#endif
