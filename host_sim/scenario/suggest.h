/// The key that a misspelt one was probably meant to be.

#ifndef SIM_SUGGEST_H
#define SIM_SUGGEST_H

#include <cyaml/cyaml.h>

#include <stdbool.h>
#include <stddef.h>

/// Finds the key of `root` that is nearest to `path` in letters changed, added or left out; false if none is near. A key
/// whose last part is that of `path` is near too ("slope" for "friction.breakaway.slope").
bool sim_suggest(const cyaml_schema_value_t *root, const char *path, char *suggestion, size_t size);

#endif
