/// A scenario: the loop's values, and in the simulator those of plant and run (scenario/config.h there).
///
/// Values come from the defaults, from a file and from --set; later ones replace earlier ones. Each value is checked for its key,
/// type and range as it is read, and every message names the place of the value.

#ifndef COMMON_SCENARIO_H
#define COMMON_SCENARIO_H

#include "loop/loop_keys.h"
#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>

/// A scenario under construction: the values and where each of them was written.
typedef struct common_scenario common_scenario_t;

/// Creates a scenario with the defaults of a table of keys, in a struct of `size` bytes that begins with a
/// common_loop_keys_t. Null if there is no memory.
common_scenario_t *common_scenario_create_of(const common_key_t *keys, size_t size);
void               common_scenario_destroy(common_scenario_t *scenario);

const common_key_t       *common_scenario_keys(const common_scenario_t *scenario);
const void               *common_scenario_values(const common_scenario_t *scenario);
const common_loop_keys_t *common_scenario_loop(const common_scenario_t *scenario);

/// Takes the keys of a scenario file, or of a file with only the keys of `compensator`. After a failure of these functions or of
/// common_scenario_set, the scenario can only be destroyed.
bool common_scenario_load(common_scenario_t *scenario, const char *path, common_error_t *error);
bool common_scenario_load_compensator(common_scenario_t *scenario, const char *path, common_error_t *error);

/// Takes one "key=value", e.g. "plant.friction.breakaway.slope=0.36" or "controller.sections[0].b0=1.5".
bool common_scenario_set(common_scenario_t *scenario, const char *assignment, common_error_t *error);

/// Takes the keys from the text of a scenario file; `name` stands for the file in messages.
bool common_scenario_load_text(common_scenario_t *scenario, const char *text, const char *name, common_error_t *error);

/// Returns where `key` was written ("FILE:LINE" or "--set key=value"); otherwise where its parent was written, or the whole file.
const char *common_scenario_source(const common_scenario_t *scenario, const char *key);

/// Return whether `key` itself has been written; whether it or a part of it has; whether a --set wrote it or a part of it last.
bool common_scenario_has(const common_scenario_t *scenario, const char *key);
bool common_scenario_has_part(const common_scenario_t *scenario, const char *key);
bool common_scenario_is_set(const common_scenario_t *scenario, const char *key);

/// Returns the path of the file that `reference.file` names, relative to the scenario file's folder, or to the current one if the
/// key came from --set. Free it; null if there is no memory.
char *common_scenario_reference_path(const common_scenario_t *scenario);

#endif
