/// The arm's position from a counter of the kernel, e.g. a quadrature decoder: one number of sysfs a tick.

#ifndef LINUX_COUNTER_H
#define LINUX_COUNTER_H

#include "support/error.h"

#include <stdbool.h>
#include <stdint.h>

#define COUNTER_PATH_MAX 255u

typedef struct
{
    char     file[COUNTER_PATH_MAX + 1]; ///< empty: none
    uint64_t bits;                       ///< 1 to 32: the counter wraps at 2^bits
} counter_config_t;

typedef struct
{
    int      file;
    uint32_t step;  ///< 2^(32 - bits): the counter times it wraps at 2^32
    uint32_t count; ///< the last, times step
    int32_t  units; ///< from where it was opened; wraps at 2^32
} counter_t;

/// False with `key`, the file and the cause in `error`.
bool counter_open(counter_t *counter, const counter_config_t *config, const char *key, common_error_t *error);
void counter_close(counter_t *counter);

/// In counts from where it was opened. What cannot be read has gone as far as a number can tell.
int32_t counter_read(counter_t *counter);

#endif
