/// The clock of the ticks, measures to keep its jitter low (a priority, locked memory, a CPU of its own), and a histogram of that
/// jitter.

#ifndef LINUX_REALTIME_H
#define LINUX_REALTIME_H

#include "support/error.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

typedef struct
{
    uint64_t priority; ///< priority of SCHED_FIFO
    int64_t  cpu;      ///< -1: any CPU
    bool     required; ///< without the privileges, true ends the program and false only warns
} realtime_config_t;

#define HISTOGRAM_BINS 32u

/// Counts of times in bins that double: below 1 us, below 2 us, ...
typedef struct
{
    uint64_t count[HISTOGRAM_BINS];
    uint64_t total;
    int64_t  longest_ns;
} histogram_t;

void histogram_add(histogram_t *histogram, int64_t time_ns);

/// Returns the time in us below which a fraction `part` of all times lies, rounded up to the limit of its bin; 0 if there
/// are none.
double histogram_quantile_us(const histogram_t *histogram, double part);

/// Prints all bins that are not empty, and the longest time.
void histogram_print(const histogram_t *histogram, const char *name, FILE *stream);

/// Returns true if this process may run on the CPU; -1 stands for any.
bool realtime_check_cpu(int64_t cpu, common_error_t *error);

/// Locks all memory and runs the calling thread with SCHED_FIFO on its CPU. Returns false with the step that was refused in
/// `error`; the steps before it have taken effect.
bool realtime_enter(const realtime_config_t *config, common_error_t *error);

/// Returns the time of CLOCK_MONOTONIC.
int64_t realtime_now_ns(void);

/// Sleeps until `due_ns`; returns at once if that time is past. Returns false if a signal came first.
bool realtime_sleep_until(int64_t due_ns);

#endif
