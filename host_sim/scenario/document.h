/// Text as a YAML document, its shape checked first: one document that is not empty, no aliases, bounded in depth and size.

#ifndef SIM_DOCUMENT_H
#define SIM_DOCUMENT_H

#include <yaml.h>

#include <stdbool.h>
#include <stddef.h>

/// What is wrong, and where, both from 1.
typedef struct
{
    size_t line, column;
    char   what[256];
} sim_document_problem_t;

/// Of a mark of libyaml.
#define SIM_LINE(mark)   ((mark).line + 1u)
#define SIM_COLUMN(mark) ((mark).column + 1u)

/// On success `document` is to be deleted with yaml_document_delete, and has a root. `nodes_max`: keys and values, mappings and lists.
bool sim_document_load(yaml_document_t        *document,
                       const char             *text,
                       unsigned                nodes_max,
                       sim_document_problem_t *problem);

#endif
