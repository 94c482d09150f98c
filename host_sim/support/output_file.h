/// Results that appear whole or not at all: written under temporary names next to their places, then renamed together. What is
/// no regular file, a device or a pipe, is written to as it is.

#ifndef SIM_OUTPUT_FILE_H
#define SIM_OUTPUT_FILE_H

#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#define SIM_OUTPUT_FILES_MAX 3u ///< most that are open at a time

/// All zeros: no file.
typedef struct
{
    FILE *stream;
    char *path;        ///< null: standard output
    char *temporary;   ///< null: `path` is written to as it is
    bool  is_unwanted; ///< nothing is to be at `path`
} sim_output_file_t;

/// Opens a temporary file next to `path` (next to what it points to, if it is a link), or standard output if `path` is null.
bool sim_output_open(sim_output_file_t *file, const char *path, sim_error_t *error);

/// What an earlier run has left at `path` is not to outlive the commit.
bool sim_output_expect_none(sim_output_file_t *file, const char *path, sim_error_t *error);

/// Checks everything written since the files were opened and puts them in their places, in order. The last one speaks for
/// the others: while it is there, they are those that belong to it, whatever ends the program. On failure nothing is left.
bool sim_output_commit(sim_output_file_t *files, size_t count, sim_error_t *error);

/// Removes what is not committed.
void sim_output_discard(sim_output_file_t *files, size_t count);

/// From now on a signal that ends the program (SIGINT, SIGTERM, SIGHUP) takes the temporary files with it. For a program's
/// main, as signals are the program's.
void sim_output_clean_on_signal(void);

/// Flushes standard output and checks everything written to it.
bool sim_output_flush(sim_error_t *error);

/// Creates the folder `path` and those above it that are missing.
bool sim_output_folder_create(const char *path, sim_error_t *error);

#endif
