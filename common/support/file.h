/// Reads files.

#ifndef COMMON_FILE_H
#define COMMON_FILE_H

#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>

/// Returns the file's bytes and a 0 after them; the caller frees them. Returns null with the error filled in if the file
/// cannot be read, is larger than `max` bytes (reading stops there), or contains a zero byte. A UTF-8 byte order mark at the
/// start is dropped.
char *common_file_read(const char *path, size_t max, common_error_t *error);

/// Returns true unless the file surely does not exist. A file that cannot be examined therefore counts as existing.
bool common_file_exists(const char *path);

/// Returns true if both paths lead to the same existing file.
bool common_file_is_same(const char *a, const char *b);

/// Returns false, with the error, if a result would replace one of the files that a run reads. Null inputs are none.
bool common_file_check_result(const char *result, const char *const *inputs, size_t count, common_error_t *error);

#endif
