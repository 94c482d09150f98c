/// Writes a scenario as it was played: every key that a file or a --set gave, with the value that counted.

#ifndef COMMON_EFFECTIVE_H
#define COMMON_EFFECTIVE_H

#include "loop/scenario.h"

#include <stdbool.h>
#include <stdio.h>

/// Writes a scenario file that plays the same run from any folder: `reference.file` becomes an absolute path. Check the
/// stream for write errors.
bool common_scenario_write(FILE *stream, const common_scenario_t *scenario, common_error_t *error);

#endif
