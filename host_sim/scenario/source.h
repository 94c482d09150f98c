/// Where each key's value was written, for messages.

#ifndef SIM_SOURCE_H
#define SIM_SOURCE_H

#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>

typedef struct
{
    struct
    {
        char *key;
        char *place; ///< "FILE:LINE" or "--set key=value"
    }     *entry;
    size_t count;
} sim_sources_t;

bool sim_sources_add(sim_sources_t *sources, const char *key, const char *place, sim_error_t *error);
void sim_sources_free(sim_sources_t *sources);

/// Whether a place is a --set, not a line of a file.
bool sim_source_is_set(const char *place);

/// The place that wrote `key` last, that of a --set of a part of it first, or else its parent, and so on up; null if there is none.
const char *sim_sources_find(const sim_sources_t *sources, const char *key);

/// Whether `key` itself has been written.
bool sim_sources_has(const sim_sources_t *sources, const char *key);

#endif
