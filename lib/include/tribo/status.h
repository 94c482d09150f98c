/// The result of a set-up function: TRIBO_OK or the fault.
///
/// A set-up function checks every field, returns the first status that applies, and writes nothing unless the status is
/// TRIBO_OK. A NaN is outside every range. A step returns a value, never a status.

#ifndef TRIBO_STATUS_H
#define TRIBO_STATUS_H

#include "tribo/parameters.h"

/// CMake and the packages take the version from here.
#define TRIBO_VERSION_MAJOR  0
#define TRIBO_VERSION_MINOR  2
#define TRIBO_VERSION_PATCH  0
#define TRIBO_VERSION_STRING "0.2.0"

#ifdef __cplusplus
extern "C" {
#endif

/// TRIBO_ERR_<symbol> of a row of tribo/parameters.h says that this parameter is out of its range, or that its
/// condition does not hold. The refusals that concern several parameters (TRIBO_REFUSALS) follow.
typedef enum
{
    TRIBO_OK = 0,
    TRIBO_ERR_NULL, ///< a pointer argument is null
#define TRIBO_STATUS_ROW(group, symbol, member, key, unit, low, high, standard, change, number, condition, sentence)   \
    TRIBO_ERR_##symbol,
    TRIBO_PARAMETERS(TRIBO_STATUS_ROW)
#undef TRIBO_STATUS_ROW
#define TRIBO_STATUS_REFUSAL(symbol, key, text) TRIBO_ERR_##symbol,
        TRIBO_REFUSALS(TRIBO_STATUS_REFUSAL)
#undef TRIBO_STATUS_REFUSAL
            TRIBO_STATUS_COUNT ///< number of statuses
} tribo_status_t;

/// Largest force in N for f32 modules; a larger one, an infinity or a NaN is a bad input.
#define TRIBO_F32_FORCE_MAX_N 1.0e6f

/// Returns the field and the allowed range of a status as one line of English, for example "sample_time_s: 1e-6 to 0.1
/// s". Never null; points to constant storage.
const char *tribo_status_text(tribo_status_t status);

/// The number that an init refuses in a list of a config, with its range in tribo/parameters.h. The text of the status
/// says what narrows that range.
typedef struct
{
    uint32_t index;            ///< section, or row of the breakaway table, from 0
    uint32_t member;           ///< number in it: 0 to 4 for b0 to a2, 0 to 2 for force_n to negative_n
    float    value, low, high; ///< inclusive
} tribo_refusal_t;

#ifdef __cplusplus
}
#endif

#endif
