/// The key, or the word of a choice, probably meant by a misspelt one.

#ifndef SIM_SUGGEST_H
#define SIM_SUGGEST_H

#include "keys/table.h"

/// Finds the key of a table that is nearest to `path` by letters changed, added or left out; false if none is near. A key with
/// the same last part is near, too ("slope" for "plant.friction.breakaway.slope").
bool sim_suggest(const sim_key_t *keys, const char *path, char suggestion[SIM_KEY_MAX]);

/// The word of a choice nearest to `text` within the same distance; null if there is none.
const char *sim_suggest_word(const sim_key_t *key, const char *text);

#endif
