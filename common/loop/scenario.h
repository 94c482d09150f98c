/// A scenario: the loop's values, and in the simulator those around it (scenario/config.h there).
///
/// Values come from three places, the later over the earlier: the defaults, a file, --set. Each is checked for its key,
/// its type and its range as it is read, and every complaint names the place it came from.

#ifndef SIM_SCENARIO_H
#define SIM_SCENARIO_H

#include "loop/loop_keys.h"
#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>

/// A scenario under construction: the values and where each of them was written.
typedef struct sim_scenario sim_scenario_t;

/// All defaults of a table of keys, in a struct of `size` bytes that begins with a sim_loop_keys_t. Null if there is no memory.
sim_scenario_t *sim_scenario_create_of(const sim_key_t *keys, size_t size);
void            sim_scenario_destroy(sim_scenario_t *scenario);

const sim_key_t       *sim_scenario_keys(const sim_scenario_t *scenario);
const void            *sim_scenario_values(const sim_scenario_t *scenario);
const sim_loop_keys_t *sim_scenario_loop(const sim_scenario_t *scenario);

/// Takes the keys of a scenario file, or of a file with the keys of `compensator` alone. After a failure, here and in
/// sim_scenario_set, the scenario is only to be destroyed.
bool sim_scenario_load(sim_scenario_t *scenario, const char *path, sim_error_t *error);
bool sim_scenario_load_compensator(sim_scenario_t *scenario, const char *path, sim_error_t *error);

/// Takes one "key=value", e.g. "plant.friction.breakaway.slope=0.36" or "controller.sections[0].b0=1.5".
bool sim_scenario_set(sim_scenario_t *scenario, const char *assignment, sim_error_t *error);

/// The same from text of a scenario file; `name` stands for the file in messages.
bool sim_scenario_load_text(sim_scenario_t *scenario, const char *text, const char *name, sim_error_t *error);

/// Where `key` was written ("FILE:LINE" or "--set key=value"), or else its parent, or else the file as a whole.
const char *sim_scenario_source(const sim_scenario_t *scenario, const char *key);

/// Whether `key` itself has been written; whether a --set wrote it or a part of it last.
bool sim_scenario_has(const sim_scenario_t *scenario, const char *key);
bool sim_scenario_is_set(const sim_scenario_t *scenario, const char *key);

/// The path of the file that `reference.file` names: from the scenario file's folder, or from the current one if the
/// key came from --set. To be freed; null if there is no memory.
char *sim_scenario_reference_path(const sim_scenario_t *scenario);

#endif
