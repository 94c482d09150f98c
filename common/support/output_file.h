/// Results that appear complete or not at all: written under temporary names next to their places, then renamed together.
/// Devices and pipes are written directly.

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
    char *temporary;   ///< null: `path` is written directly
    bool  is_unwanted; ///< the commit removes `path`
} sim_output_file_t;

/// Opens a temporary file next to `path` (for a link, next to its target), or standard output if `path` is null.
bool sim_output_open(sim_output_file_t *file, const char *path, sim_error_t *error);

/// Makes the commit remove an earlier run's file at `path`.
bool sim_output_expect_none(sim_output_file_t *file, const char *path, sim_error_t *error);

/// Checks everything written since the files were opened and puts them in their places, in order. The last one vouches for
/// the others: while it exists, they belong to it, even if the program was killed. On failure nothing is left.
bool sim_output_commit(sim_output_file_t *files, size_t count, sim_error_t *error);

/// Removes uncommitted files.
void sim_output_discard(sim_output_file_t *files, size_t count);

/// From now on SIGINT, SIGTERM and SIGHUP remove the temporary files before they end the program. Call it in main.
void sim_output_clean_on_signal(void);

/// Flushes standard output and checks everything written to it.
bool sim_output_flush(sim_error_t *error);

/// Creates the folder `path` and those above it that are missing.
bool sim_output_folder_create(const char *path, sim_error_t *error);

#endif
