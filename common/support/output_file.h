/// Results that appear complete or not at all: written next to their places, without a name where the system can do so, and under
/// temporary ones otherwise, then renamed together.
/// Devices and pipes are written directly.

#ifndef COMMON_OUTPUT_FILE_H
#define COMMON_OUTPUT_FILE_H

#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#define COMMON_OUTPUT_FILES_MAX 5u ///< most that are open at a time

/// All zeros: no file.
typedef struct
{
    FILE *stream;
    char *path;        ///< null: standard output
    char *temporary;   ///< null: `path` is written directly
    bool  is_unwanted; ///< the commit removes `path`
    bool  nameless;    ///< until the commit
} common_output_file_t;

/// Opens a temporary file next to `path` (for a link, next to its target), or standard output if `path` is null.
bool common_output_open(common_output_file_t *file, const char *path, common_error_t *error);

/// Makes the commit remove an earlier run's file at `path`.
bool common_output_expect_none(common_output_file_t *file, const char *path, common_error_t *error);

/// Checks everything written since the files were opened and puts them in their places, in order. The last one vouches for
/// the others: while it exists, they belong to it, even if the program was killed. On failure nothing is left.
bool common_output_commit(common_output_file_t *files, size_t count, common_error_t *error);

/// Removes uncommitted files.
void common_output_discard(common_output_file_t *files, size_t count);

/// From now on SIGINT, SIGTERM and SIGHUP remove the temporary files before they end the program. Call it in main.
void common_output_clean_on_signal(void);

/// Flushes standard output and checks everything written to it.
bool common_output_flush(common_error_t *error);

/// Creates the folder `path` and those above it that are missing.
bool common_output_folder_create(const char *path, common_error_t *error);

#endif
