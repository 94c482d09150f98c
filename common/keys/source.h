/// Records where each key's value was written, for messages.

#ifndef COMMON_SOURCE_H
#define COMMON_SOURCE_H

#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>

typedef struct
{
    char *key;
    char *place; ///< "FILE:LINE" or "--set key=value"
    bool  is_option;
} common_source_t;

typedef struct
{
    common_source_t *entry;
    size_t           count;
} common_sources_t;

/// Adds a source. If `line` is 0, `name` is an option and the complete place.
bool common_sources_add(common_sources_t *sources,
                        const char       *key,
                        const char       *name,
                        size_t            line,
                        common_error_t   *error);
void common_sources_free(common_sources_t *sources);

/// Returns the last source of `key`, preferably of a --set below it; otherwise that of its parent, and so on up. Null if there is
/// none.
const common_source_t *common_sources_find(const common_sources_t *sources, const char *key);

/// Returns whether `key` itself has been written. common_sources_has_part also counts a part of it.
bool common_sources_has(const common_sources_t *sources, const char *key);
bool common_sources_has_part(const common_sources_t *sources, const char *key);

#endif
