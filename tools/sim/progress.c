#include "sim/progress.h"

#include "support/clock.h"

#include <math.h>
#include <stdio.h>
#include <unistd.h>

#define CALLS_BETWEEN_LOOKS 1024u

void sim_progress_update(sim_progress_t *progress, double part_done)
{
    if (progress->calls++ % CALLS_BETWEEN_LOOKS != 0)
    {
        return;
    }
    const double now_s = common_clock_s();
    if (progress->next_s == 0.0)
    {
        progress->next_s = isatty(STDERR_FILENO) ? now_s + 1.0 : HUGE_VAL;
    }
    if (now_s >= progress->next_s)
    {
        (void)fprintf(stderr, "\r%3.0f %%", 100.0 * part_done);
        progress->next_s   = now_s + 0.5;
        progress->is_shown = true;
    }
}

void sim_progress_end(sim_progress_t *progress)
{
    if (progress->is_shown)
    {
        (void)fputs("\r     \r", stderr);
    }
}
