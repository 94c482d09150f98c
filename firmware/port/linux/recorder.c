#include "recorder.h"

#include <errno.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define WAKE_NS 20000000

struct recorder
{
    recorder_row_t       rows[RECORDER_ROWS];
    atomic_uint_fast64_t added, taken; ///< rows, by the tick and by the thread
    atomic_bool          stops;
    uint64_t             dropped; ///< by the tick alone
    int                  failed;  ///< errno of the first row that was not written
    FILE                *file;
    pthread_t            thread;
};

static void write_rows(recorder_t *recorder)
{
    const uint_fast64_t added = atomic_load_explicit(&recorder->added, memory_order_acquire);
    uint_fast64_t       taken = atomic_load_explicit(&recorder->taken, memory_order_relaxed);
    for (; taken != added; taken++)
    {
        const recorder_row_t *row = &recorder->rows[taken % RECORDER_ROWS];
        if (fprintf(recorder->file,
                    "%.6f,%.9g,%.9g,%.9g,%u,%u,%u,%.1f,%.1f\n",
                    row->t_s,
                    (double)row->r_n,
                    (double)row->y_n,
                    (double)row->u_n,
                    (unsigned)row->state,
                    (unsigned)row->fault,
                    (unsigned)row->limits,
                    (double)row->late_us,
                    (double)row->step_us) < 0 &&
            recorder->failed == 0)
        {
            recorder->failed = errno;
        }
        atomic_store_explicit(&recorder->taken, taken + 1u, memory_order_release);
    }
}

static void *work(void *context)
{
    recorder_t           *recorder = context;
    const struct timespec pause    = {.tv_nsec = WAKE_NS};
    while (!atomic_load(&recorder->stops))
    {
        write_rows(recorder);
        (void)nanosleep(&pause, NULL);
    }
    write_rows(recorder);
    return NULL;
}

recorder_t *recorder_start(const char *path, sim_error_t *error)
{
    recorder_t *recorder = calloc(1, sizeof *recorder);
    if (recorder == NULL)
    {
        (void)sim_error_set(error, "out of memory");
        return NULL;
    }
    recorder->file = fopen(path, "w");
    int status     = recorder->file == NULL ? errno : 0;
    if (status == 0)
    {
        (void)fputs("t_s,r_N,F_N,u_N,state,fault,limits,late_us,step_us\n", recorder->file);
        status = pthread_create(&recorder->thread, NULL, work, recorder);
    }
    if (status != 0)
    {
        (void)sim_error_set(error, "--log %s: %s", path, strerror(status));
        if (recorder->file != NULL)
        {
            (void)fclose(recorder->file);
        }
        free(recorder);
        return NULL;
    }
    return recorder;
}

void recorder_add(recorder_t *recorder, const recorder_row_t *row)
{
    if (recorder == NULL)
    {
        return;
    }
    const uint_fast64_t added = atomic_load_explicit(&recorder->added, memory_order_relaxed);
    if (added - atomic_load_explicit(&recorder->taken, memory_order_acquire) >= RECORDER_ROWS)
    {
        recorder->dropped++;
        return;
    }
    recorder->rows[added % RECORDER_ROWS] = *row;
    atomic_store_explicit(&recorder->added, added + 1u, memory_order_release);
}

bool recorder_stop(recorder_t *recorder, uint64_t *written, uint64_t *dropped, sim_error_t *error)
{
    atomic_store(&recorder->stops, true);
    (void)pthread_join(recorder->thread, NULL);
    *written         = atomic_load(&recorder->added);
    *dropped         = recorder->dropped;
    const int closed = fclose(recorder->file) == 0 ? 0 : errno;
    const int failed = recorder->failed != 0 ? recorder->failed : closed;
    free(recorder);
    return failed == 0 || sim_error_set(error, "--log: %s", strerror(failed));
}
