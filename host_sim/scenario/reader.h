/// Text of a scenario (YAML) into its values: each key, type, range and list is checked where it stands.

#ifndef SIM_READER_H
#define SIM_READER_H

#include "scenario/keys.h"
#include "scenario/source.h"

#define SIM_FILE_BYTES_MAX (256u * 1024u)
#define SIM_FILE_NODES_MAX 1000u ///< keys and values, mappings and lists

typedef struct
{
    const char *text;
    const char *name;      ///< for messages: the file, or "--set key=value"
    bool        is_option; ///< a --set: a line number would mean nothing

    const char      *prefix; ///< the path of the mapping that the text is, "" or "compensator"
    const sim_key_t *keys;   ///< what may be in it
    const sim_key_t *only;   ///< of a --set: the one key that may be in it; else null
    char            *group;  ///< the struct that they are about
} sim_text_t;

/// Puts the values that the text gives into the struct and notes where they were written. The struct is of no use after a
/// failure.
bool sim_read(const sim_text_t *text, sim_sources_t *sources, sim_error_t *error);

#endif
