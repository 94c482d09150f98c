/// One key of a scenario, as a row of a table: what it is called, what it may be, where its value goes.
///
/// The table itself is scenario/keys.c; a truth model brings the rows of its own keys (plant/truth.h).

#ifndef SIM_KEY_H
#define SIM_KEY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum
{
    SIM_KEY_NUMBER,   ///< double
    SIM_KEY_OPTIONAL, ///< sim_optional_t: a number that may be left out
    SIM_KEY_WHOLE,    ///< uint64_t
    SIM_KEY_CHOICE,   ///< int, the index of a word
    SIM_KEY_TEXT,     ///< char[max + 1]
    SIM_KEY_GROUP,    ///< a mapping with keys of its own
    SIM_KEY_LIST      ///< an array of such mappings, and an unsigned that counts them
} sim_key_type_t;

typedef struct
{
    bool   is_given;
    double value;
} sim_optional_t;

/// A table is an array of rows; one without a name ends it.
typedef struct sim_key
{
    const char                  *name;
    sim_key_type_t               type;
    bool                         is_required;   ///< has no default
    size_t                       offset;        ///< of the value, in the struct that the table is about
    const char                  *unit;          ///< "-": none
    double                       min, max;      ///< of a number; how long a text or a list may be
    double                       standard;      ///< the default; of a choice its index
    const char *const           *words;         ///< of a choice, ended by null
    const struct sim_key        *keys;          ///< of a group or of a list's elements
    const struct sim_key *const *keys_of_model; ///< of a group, instead: where a truth model has them
    size_t                       size;          ///< of a list's element
    size_t                       count_offset;  ///< of a list's counter
    uint64_t                     statuses;      ///< the library's refusals that are about this key, a bit each
    const char                  *text;          ///< for the tables of scenarios/README.md; of a group its title
} sim_key_t;

#endif
