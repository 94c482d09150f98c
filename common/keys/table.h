/// Looks keys up in a table.
///
/// A key's row is the only source for reading, --set, defaults, ranges, suggestions and lists of keys.

#ifndef COMMON_TABLE_H
#define COMMON_TABLE_H

#include "keys/key.h"

/// Room for the longest key path, e.g. "compensator.friction.breakaway.table[31].negative_N".
#define COMMON_KEY_MAX 128u

/// The target of a key path.
typedef struct
{
    const common_key_t *key;
    char               *at;         ///< the value; null if a list in the path has no such element
    unsigned            count;      ///< number of that list's elements
    bool                is_element; ///< the path ends at an element of the list `key`
} common_place_t;

/// Finds a key by its path. Returns false if the table has no such key. `values` is the struct that the table describes, or
/// null if places do not matter.
bool common_key_find(const common_key_t *keys, void *values, const char *path, common_place_t *place);

/// Returns the row called `name`, of `length` characters, in one table; null if there is none.
const common_key_t *common_key_in(const common_key_t *keys, const char *name, size_t length);

/// Returns the rows of a group or of a list's elements. Null if a truth model has no keys of its own; its group does not
/// exist then.
const common_key_t *common_key_below(const common_key_t *key);

/// Calls `visit` with every key, in the table's order; "[]" in the path stands for any element of a list.
typedef void (*common_key_visitor_t)(void *context, const char *path, const common_key_t *key);
void common_key_visit(const common_key_t *keys, common_key_visitor_t visit, void *context);

/// Sets the defaults of a table's rows in its struct. Rows without a default are left unchanged.
void common_key_set_defaults(const common_key_t *keys, char *group);

/// Returns the name of a value's type in messages, e.g. "a number".
const char *common_key_type_name(const common_key_t *key);

/// Room for the words of the longest choice.
#define COMMON_WORDS_MAX 512u

/// Writes the words of a choice to `text`, e.g. "triangle, sine or step".
void common_key_words(const common_key_t *key, char *text, size_t size);

/// Returns the index of a word of a choice; -1 if it is unknown. `false` and `true` stand for `no` and `yes`.
int common_key_find_word(const common_key_t *key, const char *word);

#endif
