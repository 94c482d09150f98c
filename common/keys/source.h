/// Where each key's value was written, for messages.

#ifndef SIM_SOURCE_H
#define SIM_SOURCE_H

#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>

typedef struct
{
    char *key;
    char *place; ///< "FILE:LINE" or "--set key=value"
    bool  is_option;
} sim_source_t;

typedef struct
{
    sim_source_t *entry;
    size_t        count;
} sim_sources_t;

/// Line 0: `name` is an option and the complete place.
bool sim_sources_add(sim_sources_t *sources, const char *key, const char *name, size_t line, sim_error_t *error);
void sim_sources_free(sim_sources_t *sources);

/// The last source of `key`, preferably a --set below it; else that of its parent, and so on up. Null if there is none.
const sim_source_t *sim_sources_find(const sim_sources_t *sources, const char *key);

/// True if `key` itself has been written.
bool sim_sources_has(const sim_sources_t *sources, const char *key);

#endif
