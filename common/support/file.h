/// Reading files.

#ifndef COMMON_FILE_H
#define COMMON_FILE_H

#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>

/// The file's bytes and a 0 after them, to be freed by the caller. Null with the error filled in if it cannot be read, is
/// larger than `max` bytes (reading stops there), or contains a zero byte. A UTF-8 byte order mark at the start is dropped.
char *common_file_read(const char *path, size_t max, common_error_t *error);

/// Also one that cannot be looked at: only what is surely not there has a substitute.
bool common_file_exists(const char *path);

/// True if both paths lead to the same existing file.
bool common_file_is_same(const char *a, const char *b);

#endif
