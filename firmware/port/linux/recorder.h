/// Writes the log of a drive: the tick puts one row into a ring, and a thread writes the ring as the CSV that `tribo-sim
/// replay` reads. The tick never waits: a row for which there is no room is dropped and counted. A disk that refuses rows,
/// e.g. a full one, is reported on standard error, and so is its recovery. The file always has whole rows. The end waits for
/// a pipe or a disk only while it accepts rows.
///
///     t_s,r_N,F_N,u_N,state,fault,limits,late_us,step_us        F_N: the sensor's reading

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

/// Starts the thread. `path` must outlive it. Returns null with the cause in `error`.
recorder_t *recorder_start(const char *path, common_error_t *error);

/// Replaces the file by one without rows. Call it last, when the run can begin. Returns false with the path and the cause in `error`.
/// It does nothing if the recorder is null.
bool recorder_open(recorder_t *recorder, common_error_t *error);

/// Adds a row. Only the tick calls this. It does nothing if the recorder is null.
void recorder_add(recorder_t *recorder, const recorder_row_t *row);

/// Writes the remaining rows and closes the file. Returns false, with the cause in `error`, if the disk has ever refused a row.
/// `dropped` and `written` count rows.
bool recorder_stop(recorder_t *recorder, uint64_t *written, uint64_t *dropped, common_error_t *error);

#endif
