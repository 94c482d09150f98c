/// Progress of a long run on stderr, if that is a terminal.

#ifndef SIM_PROGRESS_H
#define SIM_PROGRESS_H

#include <stdbool.h>
#include <stdint.h>

typedef struct
{
    bool     shown; ///< something is on the line
    bool     is_terminal;
    uint32_t calls;
    double   next_s; ///< when to write next
} sim_progress_t;

void sim_progress_start(sim_progress_t *progress);

/// Costs next to nothing; writes at most twice a second, for the first time after one second.
void sim_progress_update(sim_progress_t *progress, double part_done);

/// Clears the line.
void sim_progress_end(sim_progress_t *progress);

#endif
