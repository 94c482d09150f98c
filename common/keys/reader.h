/// Reads a file's text (YAML) into a struct; errors in keys, types, ranges and lists name the line.

#ifndef SIM_READER_H
#define SIM_READER_H

#include "keys/source.h"
#include "keys/table.h"

#define SIM_FILE_BYTES_MAX (256u * 1024u)
#define SIM_FILE_NODES_MAX 1000u ///< keys and values, mappings and lists

typedef struct
{
    const char *text;
    const char *name;      ///< for messages: the file, or "--set key=value"
    bool        is_option; ///< a --set: messages give no line number

    const char      *prefix; ///< the path of the text's mapping, "" or "compensator"
    const sim_key_t *root;   ///< the whole table, to suggest keys for unknown ones
    const sim_key_t *keys;   ///< keys allowed in the mapping
    const sim_key_t *only;   ///< of a --set: its only key; else null
    char            *group;  ///< the struct to fill
} sim_text_t;

/// Stores the text's values in the struct and records their sources. After a failure the struct is undefined.
bool sim_read(const sim_text_t *text, sim_sources_t *sources, sim_error_t *error);

#endif
