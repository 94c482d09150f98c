#include "cli/progress.h"

#include <stdio.h>
#include <time.h>
#include <unistd.h>

#define CALLS_BETWEEN_LOOKS 1024u

static double now_s(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void sim_progress_start(sim_progress_t *progress)
{
    *progress = (sim_progress_t){.is_terminal = isatty(STDERR_FILENO) != 0, .next_s = now_s() + 1.0};
}

void sim_progress_update(sim_progress_t *progress, double part_done)
{
    if (!progress->is_terminal || ++progress->calls % CALLS_BETWEEN_LOOKS != 0)
    {
        return;
    }
    const double now = now_s();
    if (now >= progress->next_s)
    {
        (void)fprintf(stderr, "\r%3.0f %%", 100.0 * part_done);
        progress->next_s = now + 0.5;
        progress->shown  = true;
    }
}

void sim_progress_end(sim_progress_t *progress)
{
    if (progress->shown)
    {
        (void)fputs("\r     \r", stderr);
    }
}
