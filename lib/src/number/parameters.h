// The checks that every set-up makes of its config, from the rows of tribo/parameters.h.

#ifndef TRIBO_NUMBER_PARAMETERS_H
#define TRIBO_NUMBER_PARAMETERS_H

#include "tribo/parameters.h"
#include "tribo/status.h"

#include <stdbool.h>
#include <stdint.h>

/// TRIBO_OK, or the status of the first of `count` members of `config` that is out of its range.
tribo_status_t tribo_parameters_check(const tribo_parameter_t *rows, uint32_t count, const void *config);

/// The same of a whole table.
#define PARAMETERS_CHECK(rows, config) tribo_parameters_check(rows, sizeof(rows) / sizeof((rows)[0]), config)

// Of arguments that are in no config.
#define PARAMETERS_WITHIN(group, symbol, member, key, unit, low, high, standard, change, number, condition, sentence)  \
    (member) >= (float)(low) && (member) <= (float)(high)

static inline bool sample_time_ok(float sample_time_s)
{
    return TRIBO_SAMPLE_PARAMETERS(PARAMETERS_WITHIN);
}

static inline bool full_scale_ok(float full_scale_n)
{
    return TRIBO_SCALE_PARAMETERS(PARAMETERS_WITHIN);
}

/// A member's default in an initialiser of its config.
#define PARAMETERS_DEFAULT(group, symbol, member, key, unit, low, high, standard, change, number, condition, sentence) \
    .member = (float)(standard),

#endif
