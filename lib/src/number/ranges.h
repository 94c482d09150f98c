// Every set-up checks its config with these functions. The ranges are the rows of tribo/parameters.h.

#ifndef TRIBO_NUMBER_RANGES_H
#define TRIBO_NUMBER_RANGES_H

#include "tribo/parameters.h"
#include "tribo/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Checks `count` members of `config`. Returns TRIBO_OK or the status of the first one that is out of its range.
tribo_status_t tribo_parameters_check(const tribo_parameter_t *rows, uint32_t count, const void *config);

/// Does what tribo_parameters_check does, for all rows of an array.
#define PARAMETERS_CHECK(rows, config) tribo_parameters_check(rows, sizeof(rows) / sizeof((rows)[0]), config)

/// Writes to `refusal`, unless it is null, that number `member` of element `index` of a list is refused. `rows` has a
/// row for each number of an element. Returns `status`.
tribo_status_t tribo_element_refuse(tribo_status_t           status,
                                    const tribo_parameter_t *rows,
                                    uint32_t                 member,
                                    const void              *element,
                                    uint32_t                 index,
                                    tribo_refusal_t         *refusal);

/// Checks the `count` numbers of an element. Returns TRIBO_OK, or refuses the first one that is out of its range.
tribo_status_t tribo_element_check(const tribo_parameter_t *rows,
                                   uint32_t                 count,
                                   const void              *element,
                                   uint32_t                 index,
                                   tribo_refusal_t         *refusal);

/// The row for a number of the struct `element`.
#define PARAMETERS_ELEMENT(element, symbol, member, key, unit, low_, high_, sentence)                                  \
    {.low = (float)(low_), .high = (float)(high_), .at = offsetof(element, member), .status = TRIBO_ERR_##symbol},

/// The row for a member of the struct `config`.
#define PARAMETERS_ROW(config, group, symbol, member, key, unit, low_, high_, standard_, change, number_, ...)         \
    {.low      = (float)(low_),                                                                                        \
     .high     = (float)(high_),                                                                                       \
     .standard = (float)(standard_),                                                                                   \
     .at       = offsetof(config, member),                                                                             \
     .number   = (number_),                                                                                            \
     .status   = TRIBO_ERR_##symbol,                                                                                   \
     .is_whole = _Generic(((config *)0)->member, float: 0, uint32_t: 1),                                               \
     .protects = TRIBO_##change},

// Limits of a parameter that is an argument instead of a member of a config. Its list has this one row.
#define PARAMETERS_LOW(group, symbol, member, key, unit, low, high, ...)  (float)(low)
#define PARAMETERS_HIGH(group, symbol, member, key, unit, low, high, ...) (float)(high)

static inline bool sample_time_ok(float sample_time_s)
{
    return sample_time_s >= TRIBO_SAMPLE_PARAMETERS(PARAMETERS_LOW) &&
           sample_time_s <= TRIBO_SAMPLE_PARAMETERS(PARAMETERS_HIGH);
}

static inline bool full_scale_ok(float full_scale_n)
{
    return full_scale_n >= TRIBO_SCALE_PARAMETERS(PARAMETERS_LOW) &&
           full_scale_n <= TRIBO_SCALE_PARAMETERS(PARAMETERS_HIGH);
}

/// The default of a member, in an initialiser of its config.
#define PARAMETERS_DEFAULT(group, symbol, member, key, unit, low, high, standard, change, number, condition, sentence) \
    .member = (float)(standard),

#endif
