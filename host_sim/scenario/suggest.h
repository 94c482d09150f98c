/// The key, or the word of a choice, that a misspelt one was probably meant to be.

#ifndef SIM_SUGGEST_H
#define SIM_SUGGEST_H

#include "scenario/keys.h"

/// Finds the key that is nearest to `path` in letters changed, added or left out; false if none is near. A key whose last
/// part is that of `path` is near too ("slope" for "plant.friction.breakaway.slope").
bool sim_suggest(const char *path, char suggestion[SIM_KEY_MAX]);

/// The word of a choice that is nearest to `text`, within the same distance; null if none is.
const char *sim_suggest_word(const sim_key_t *key, const char *text);

#endif
