/// Writes result files that appear complete or not at all. They are written next to their places, without a name if the system
/// supports that and under temporary names otherwise, and then renamed together. A new file has the mode of the one it replaces,
/// and its group and owner where this user may set them. Devices, pipes and paths of descriptors (/dev/stdout) are written
/// directly.

#ifndef COMMON_OUTPUT_FILE_H
#define COMMON_OUTPUT_FILE_H

#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#define COMMON_OUTPUT_FILES_MAX 5u ///< most files that are open at a time

/// A file to write; all zeros if there is none.
typedef struct
{
    FILE *stream;
    char *path;        ///< null: standard output
    char *temporary;   ///< null: `path` is written directly
    bool  is_unwanted; ///< the commit removes `path`
    bool  nameless;    ///< the file has no name until the commit
} common_output_file_t;

/// Opens a temporary file next to `path` (for a link, next to its target), or standard output if `path` is null.
/// A file that must not be written, also one without any write permission, is an error.
bool common_output_open(common_output_file_t *file, const char *path, common_error_t *error);

/// Returns the descriptor that a path such as /dev/stdout names; -1 if it names none.
int common_output_descriptor(const char *path);

/// Checks that `path` can be opened so, and leaves nothing there: called before long work whose result goes to `path`. Accepts a
/// null path, a device or a pipe unseen.
bool common_output_check(const char *path, common_error_t *error);

/// Makes the commit remove an earlier run's file at `path`.
bool common_output_expect_none(common_output_file_t *file, const char *path, common_error_t *error);

/// Checks everything written since the files were opened and puts them in their places, in order. The last one vouches for
/// the others: while it exists, they belong to it, even if the program was killed. On failure no file is left.
bool common_output_commit(common_output_file_t *files, size_t count, common_error_t *error);

/// Removes uncommitted files.
void common_output_discard(common_output_file_t *files, size_t count);

/// Fills standard descriptors that the caller has closed, so that no result file gets their number and a line of a message.
/// Reading from them or writing to them still fails. Call it first in main.
void common_output_fill_descriptors(void);

/// Makes SIGINT, SIGTERM and SIGHUP remove the temporary files before they end the program. Call it in main.
void common_output_clean_on_signal(void);

/// Flushes standard output and checks everything written to it.
bool common_output_flush(common_error_t *error);

/// Creates the folder `path` and those above it that are missing. A discard or a signal removes them again if they are empty; a commit
/// keeps them.
bool common_output_folder_create(const char *path, common_error_t *error);

/// Creates a folder as mkdtemp does. A discard or a signal removes it in the same way. Returns false with errno set on failure.
bool common_output_folder_temporary(char *path);

#endif
