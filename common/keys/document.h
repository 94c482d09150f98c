/// Loads text as a YAML document after checking its shape: one document, not empty, no aliases, bounded in depth and size.

#ifndef COMMON_DOCUMENT_H
#define COMMON_DOCUMENT_H

#include <yaml.h>

#include <stdbool.h>
#include <stddef.h>

/// A fault and its place. Line and column count from 1.
typedef struct
{
    size_t line, column;
    char   what[256];
} common_document_problem_t;

/// Line and column of a libyaml mark, which count from 0 there.
#define COMMON_LINE(mark)   ((mark).line + 1u)
#define COMMON_COLUMN(mark) ((mark).column + 1u)

/// Loads `text`. On success `document` has a root; delete it with yaml_document_delete. `nodes_max` limits the number of keys,
/// values, mappings and lists.
bool common_document_load(yaml_document_t           *document,
                          const char                *text,
                          unsigned                   nodes_max,
                          common_document_problem_t *problem);

#endif
