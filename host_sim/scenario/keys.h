/// The table of keys: what a scenario may hold, with unit, range, default, text, and where each value goes.
///
/// Everything that knows a key knows it from here: reading, --set, defaults, ranges, suggestions, `tribo-sim list --keys`
/// and the tables of scenarios/README.md.

#ifndef SIM_KEYS_H
#define SIM_KEYS_H

#include "scenario/config.h"
#include "support/key.h"
#include "tribo/status.h"

/// Room for the longest key path, e.g. "compensator.friction.breakaway.table[31].negative_N".
#define SIM_KEY_MAX 128u

extern const sim_key_t sim_keys[]; ///< of sim_config_t

/// Where a key path leads.
typedef struct
{
    const sim_key_t *key;
    char            *at;         ///< the value; null if a list in the path has no such element
    unsigned         count;      ///< of that list's elements
    bool             is_element; ///< the path ends at an element of the list `key`
} sim_place_t;

/// False if there is no such key.
bool sim_key_find(sim_config_t *config, const char *path, sim_place_t *place);

/// The row called `name` of `length` characters in one table; null if there is none.
const sim_key_t *sim_key_in(const sim_key_t *keys, const char *name, size_t length);

/// The rows of a group or of a list's elements. Null if a truth model has no keys of its own; there is no such group then.
const sim_key_t *sim_key_below(const sim_key_t *key);

/// Calls `visit` with every key, in the table's order; "[]" in the path stands for any element of a list.
typedef void (*sim_key_visitor_t)(void *context, const char *path, const sim_key_t *key);
void sim_key_visit(sim_key_visitor_t visit, void *context);

/// The defaults of a table's rows in the struct that it is about. What has none stays as it is.
void sim_key_set_defaults_below(const sim_key_t *keys, char *group);

/// All defaults; 0 where there is none.
void sim_key_set_defaults(sim_config_t *config);

/// What a value of this type is called in a message, e.g. "a number".
const char *sim_key_type_name(const sim_key_t *key);

/// Room for the words of the longest choice.
#define SIM_WORDS_MAX 512u

/// The words of a choice, "triangle, sine or step", in `text`.
void sim_key_words(const sim_key_t *key, char *text, size_t size);

/// The index of a word among those of a choice, with `false` and `true` for `no` and `yes`; -1 if it is none of them.
int sim_key_find_word(const sim_key_t *key, const char *word);

/// The path of the key that a refusal of the library is about, "" if it is about none.
void sim_key_of_status(tribo_status_t status, char path[SIM_KEY_MAX]);

#endif
