/// Reads the arm's position from a counter of the kernel, e.g. a quadrature decoder: one number of sysfs a tick.

#ifndef LINUX_COUNTER_H
#define LINUX_COUNTER_H

#include "support/error.h"

#include <stdbool.h>
#include <stdint.h>

#define COUNTER_PATH_MAX 255u

typedef struct
{
    char     file[COUNTER_PATH_MAX + 1]; ///< empty: no counter
    uint64_t bits;                       ///< 1 to 32: the counter wraps at 2^bits
} counter_config_t;

typedef struct
{
    int      file;
    uint32_t step;  ///< 2^(32 - bits); the counter times this wraps at 2^32
    uint32_t count; ///< the last count times `step`
    int32_t  units; ///< counts since the counter was opened; wraps at 2^32
} counter_t;

/// Opens the counter. Returns false with `key`, the file and the cause in `error`.
bool counter_open(counter_t *counter, const counter_config_t *config, const char *key, common_error_t *error);
void counter_close(counter_t *counter);

/// Returns the position in counts since the counter was opened. A counter that cannot be read moves by the largest number,
/// so that the speed's check stops the drive.
int32_t counter_read(counter_t *counter);

#endif
