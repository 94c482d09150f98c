/// Progress of a long run on stderr, if that is a terminal.

#ifndef SIM_PROGRESS_H
#define SIM_PROGRESS_H

#include <stdbool.h>
#include <stdint.h>

/// All zeros to begin with.
typedef struct
{
    uint32_t calls;
    double   next_s; ///< when to write next
    bool     is_shown;
} sim_progress_t;

/// Costs next to nothing; writes at most twice a second, for the first time after one second.
void sim_progress_update(sim_progress_t *progress, double part_done);

/// Clears the line.
void sim_progress_end(sim_progress_t *progress);

#endif
