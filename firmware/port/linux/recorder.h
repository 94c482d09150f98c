/// The log of a drive: a row a tick into a ring, which a thread of its own writes as the CSV that `tribo-sim replay` reads.
/// The tick never waits: a row that finds no room is dropped and counted. A disk that takes nothing, e.g. a full one, is told on
/// standard error when it happens and when it takes rows again; the file has whole rows.
///
///     t_s,r_N,F_N,u_N,state,fault,limits,late_us,step_us        F_N: what the sensor said

#ifndef LINUX_RECORDER_H
#define LINUX_RECORDER_H

#include "support/error.h"

#include <stdbool.h>
#include <stdint.h>

#define RECORDER_ROWS 16384u ///< a power of two: 16 s at 1 kHz

typedef struct
{
    double   t_s;
    float    r_n, y_n, u_n;
    uint32_t state, fault, limits;
    float    late_us, step_us;
} recorder_row_t;

typedef struct recorder recorder_t;

/// Makes the file and starts the thread. `path` outlives it. Null with the path and why in `error`.
recorder_t *recorder_start(const char *path, common_error_t *error);

/// From one thread: the tick's. Null takes no rows.
void recorder_add(recorder_t *recorder, const recorder_row_t *row);

/// Writes what is left and closes the file. False if the disk has refused a row, in `error`, also if it took it later. `dropped` and
/// `written`: rows.
bool recorder_stop(recorder_t *recorder, uint64_t *written, uint64_t *dropped, common_error_t *error);

#endif
