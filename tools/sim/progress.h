/// Progress of a long run on stderr, if that is a terminal.

#ifndef SIM_PROGRESS_H
#define SIM_PROGRESS_H

#include <stdbool.h>
#include <stdint.h>

/// Starts as all zeros.
typedef struct
{
    uint32_t calls;
    double   next_s; ///< when to write next
    bool     is_shown;
} sim_progress_t;

/// Cheap; writes at most twice a second, first after one second.
void sim_progress_update(sim_progress_t *progress, double part_done);

/// Clears the line.
void sim_progress_end(sim_progress_t *progress);

#endif
