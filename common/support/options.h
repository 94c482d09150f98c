/// Finds options that were given twice on the command line of a program, which argp reads.

#ifndef COMMON_OPTIONS_H
#define COMMON_OPTIONS_H

#include "support/error.h"

#include <argp.h>
#include <stdbool.h>
#include <stddef.h>

#define COMMON_OPTIONS_MAX 4096u ///< on a command line

/// Notes the option of `key`, if `known` has it. Returns false with the error filled in if it excludes one that was noted before.
/// An option is given once. One that takes NAME=VALUE is given once for each NAME, but {mappings} add to each other. One whose
/// text says "may be repeated" is given as often as needed.
bool common_options_add(const struct argp_option *known, int key, const char *value, common_error_t *error);

/// Returns the option that was noted as number `i`, from 0; null if there are not so many.
const struct argp_option *common_options_at(size_t i);

#endif
