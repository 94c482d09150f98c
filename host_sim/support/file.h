/// Files to read.

#ifndef SIM_FILE_H
#define SIM_FILE_H

#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>

/// The file's bytes and a 0 after them, to be freed by the caller; null with the error filled in if it cannot be read, is
/// larger than `max` bytes (read no further than that), or has a zero byte in it. A UTF-8 byte order mark at the start is
/// left out.
char *sim_file_read(const char *path, size_t max, sim_error_t *error);

/// Whether both paths lead to one file that exists.
bool sim_file_is_same(const char *a, const char *b);

#endif
