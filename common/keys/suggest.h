/// Finds the key, or the word of a choice, that a misspelt one probably means.

#ifndef COMMON_SUGGEST_H
#define COMMON_SUGGEST_H

#include "keys/table.h"

/// Finds the key of a table that is nearest to `path` by letters changed, added or omitted. Returns false if none is near. A key
/// with the same last part also counts as near ("slope" for "plant.friction.breakaway.slope").
bool common_suggest(const common_key_t *keys, const char *path, char suggestion[COMMON_KEY_MAX]);

/// Returns the word of a choice nearest to `text` within the same distance; null if there is none.
const char *common_suggest_word(const common_key_t *key, const char *text);

#endif
