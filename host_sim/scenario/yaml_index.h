/// Every key of a YAML document with its line, found with libyaml: what libcyaml does not tell about a document that
/// it loads, and more strictly than it looks (duplicates, aliases, several documents).

#ifndef SIM_YAML_INDEX_H
#define SIM_YAML_INDEX_H

#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>

typedef enum
{
    SIM_YAML_SCALAR,
    SIM_YAML_MAPPING,
    SIM_YAML_LIST
} sim_yaml_kind_t;

typedef struct
{
    char           *path; ///< "reference.kind", "controller.sections[0].b0"
    char           *text; ///< of a scalar; else null
    sim_yaml_kind_t kind;
    size_t          line;   ///< of the key
    size_t          column; ///< of the value
    size_t          value_line;
} sim_yaml_entry_t;

typedef struct
{
    sim_yaml_entry_t *entry;
    size_t            count;
} sim_yaml_index_t;

/// Indexes `text`. `name` is what errors name: "NAME:LINE: ..." or, if `name_only`, "NAME: ...". Nothing is left to
/// free on failure.
bool sim_yaml_index_build(sim_yaml_index_t *index,
                          const char       *text,
                          const char       *name,
                          bool              name_only,
                          sim_error_t      *error);
void sim_yaml_index_free(sim_yaml_index_t *index);

/// The entry of `path`; null if there is none.
const sim_yaml_entry_t *sim_yaml_index_find(const sim_yaml_index_t *index, const char *path);

#endif
