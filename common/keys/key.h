/// One key of a file, as a row of a table: its name, type and range, and the place of its value.

#ifndef COMMON_KEY_H
#define COMMON_KEY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum
{
    COMMON_KEY_NUMBER,   ///< double
    COMMON_KEY_OPTIONAL, ///< common_optional_t: a number that may be missing
    COMMON_KEY_WHOLE,    ///< uint64_t
    COMMON_KEY_CHOICE,   ///< int, the index of a word
    COMMON_KEY_TEXT,     ///< char[max + 1]
    COMMON_KEY_GROUP,    ///< a mapping with its own keys
    COMMON_KEY_LIST,     ///< an array of such mappings, with an unsigned for its length
    COMMON_KEY_SKIPPED   ///< a key of another program, whose value is ignored
} common_key_type_t;

typedef struct
{
    bool   is_given;
    double value;
} common_optional_t;

/// A table is an array of rows. A row without a name ends it.
typedef struct common_key
{
    const char                     *name;
    common_key_type_t               type;
    bool                            is_required;   ///< the key has no default
    size_t                          offset;        ///< offset of the value in the struct that the table describes
    const char                     *unit;          ///< "-": none
    double                          min, max;      ///< range of a number, or of the length of a text or list
    double                          standard;      ///< the default; for a choice its index
    const char *const              *words;         ///< words of a choice, ended by null
    const struct common_key        *keys;          ///< keys of a group or of a list's elements
    const struct common_key *const *keys_of_model; ///< for a group, instead of `keys`: pointer to a truth model's keys
    size_t                          size;          ///< size of a list's element
    size_t                          count_offset;  ///< offset of a list's counter
    const char                     *text;          ///< meaning, for `tribo-sim list`; the title of a group
} common_key_t;

#endif
