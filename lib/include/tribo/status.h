/// Result of a set-up function: TRIBO_OK or the fault.
///
/// Set-up functions check every field, return the first status that applies and write nothing unless it is TRIBO_OK. NaN is
/// outside every range. Steps return values, never a status.

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

/// TRIBO_ERR_<symbol> of each row of tribo/parameters.h: the parameter of that name is out of its range, or its condition does not
/// hold. After them the refusals that concern several parameters (TRIBO_REFUSALS).
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
            TRIBO_STATUS_COUNT ///< of statuses
} tribo_status_t;

/// Largest force in N for f32 modules; a larger one, an infinity or a NaN is a bad input.
#define TRIBO_F32_FORCE_MAX_N 1.0e6f

/// A status's field and allowed range, as one line of English, e.g.
/// "sample_time_s: 1e-6 to 0.1 s". Never null; points to constant storage.
const char *tribo_status_text(tribo_status_t status);

/// The number that is refused in a list of a config, with its range in tribo/parameters.h; the status's text says what may narrow it.
typedef struct
{
    uint32_t index;            ///< of the section, or of the row of the breakaway table, from 0
    uint32_t member;           ///< the number in it: 0 to 4 for b0 to a2, 0 to 2 for force_n to negative_n
    float    value, low, high; ///< inclusive
} tribo_refusal_t;

#ifdef __cplusplus
}
#endif

#endif
