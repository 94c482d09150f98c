/// Monotonic time.

#ifndef SIM_CLOCK_H
#define SIM_CLOCK_H

#include <time.h>

static inline double sim_clock_s(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

#endif
