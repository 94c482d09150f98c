/// Reads a file's text (YAML) into a struct. Errors in keys, types, ranges and lists name the line.

#ifndef COMMON_READER_H
#define COMMON_READER_H

#include "keys/source.h"
#include "keys/table.h"

#define COMMON_FILE_BYTES_MAX (256u * 1024u)
#define COMMON_FILE_NODES_MAX 1000u ///< most keys, values, mappings and lists

typedef struct
{
    const char *text;
    const char *name;      ///< for messages: the file, or "--set key=value"
    bool        is_option; ///< the text is a --set: messages give no line number

    const char         *prefix; ///< the path of the text's mapping, "" or "compensator"
    const common_key_t *root;   ///< the whole table, to suggest keys for unknown ones
    const common_key_t *keys;   ///< keys allowed in the mapping
    const common_key_t *only;   ///< the only key of a --set; otherwise null
    char               *group;  ///< the struct to fill
} common_text_t;

/// Stores the text's values in the struct and records their sources. After a failure the struct is undefined.
bool common_read(const common_text_t *text, common_sources_t *sources, common_error_t *error);

#endif
