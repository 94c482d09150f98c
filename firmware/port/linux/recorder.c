#include "recorder.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define WAKE_NS 20000000

#define ROW_BYTES  192u ///< more than a row has
#define PART_BYTES 16384u

struct recorder
{
    recorder_row_t       rows[RECORDER_ROWS];
    atomic_uint_fast64_t added, taken; ///< rows, by the tick and by the thread
    atomic_bool          stops;
    uint64_t             dropped; ///< by the tick alone
    const char          *path;    ///< for messages
    int                  file;
    int                  failed;   ///< errno of the first row that was not written
    bool                 is_stuck; ///< the last try failed
    pthread_t            thread;
};

static size_t print_row(char *text, const recorder_row_t *row)
{
    const int length = snprintf(text,
                                ROW_BYTES,
                                "%.6f,%.9g,%.9g,%.9g,%u,%u,%u,%.1f,%.1f\n",
                                row->t_s,
                                (double)row->r_n,
                                (double)row->y_n,
                                (double)row->u_n,
                                (unsigned)row->state,
                                (unsigned)row->fault,
                                (unsigned)row->limits,
                                (double)row->late_us,
                                (double)row->step_us);
    return length > 0 && length < (int)ROW_BYTES ? (size_t)length : 0u;
}

/// All of it or, where the disk took a part, nothing: the file ends with a whole row. What takes no truncation is no file.
static int write_whole(int file, const char *text, size_t length)
{
    size_t  done = 0;
    ssize_t part = 0;
    while (done < length && (part = write(file, text + done, length - done)) >= 0)
    {
        done += (size_t)part;
    }
    const int failed = part < 0 ? errno : 0;
    if (failed != 0 && done > 0u)
    {
        const off_t end = lseek(file, 0, SEEK_CUR);
        (void)!(end >= 0 && ftruncate(file, end - (off_t)done) == 0 && lseek(file, end - (off_t)done, SEEK_SET) >= 0);
    }
    return failed;
}

/// When it happens: the drive goes on, and rows that find no room until the disk takes them are dropped.
static void report(recorder_t *recorder, int failed)
{
    if ((failed != 0) != recorder->is_stuck)
    {
        (void)fprintf(stderr,
                      "%s: --log %s: %s; the drive goes on\n",
                      program_invocation_short_name,
                      recorder->path,
                      failed != 0 ? strerror(failed) : "rows are written again");
    }
    recorder->is_stuck = failed != 0;
    recorder->failed   = recorder->failed != 0 ? recorder->failed : failed;
}

static void write_rows(recorder_t *recorder)
{
    static char         text[PART_BYTES];
    const uint_fast64_t added  = atomic_load_explicit(&recorder->added, memory_order_acquire);
    uint_fast64_t       taken  = atomic_load_explicit(&recorder->taken, memory_order_relaxed);
    int                 failed = 0;
    while (taken != added && failed == 0)
    {
        size_t        length = 0;
        uint_fast64_t part   = taken;
        for (; part != added && length + ROW_BYTES <= sizeof text; part++)
        {
            length += print_row(text + length, &recorder->rows[part % RECORDER_ROWS]);
        }
        failed = write_whole(recorder->file, text, length);
        report(recorder, failed);
        if (failed == 0)
        {
            taken = part;
            atomic_store_explicit(&recorder->taken, taken, memory_order_release);
        }
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

recorder_t *recorder_start(const char *path, common_error_t *error)
{
    recorder_t *recorder = calloc(1, sizeof *recorder);
    if (recorder == NULL)
    {
        (void)common_error_set(error, "out of memory");
        return NULL;
    }
    static const char head[] = "t_s,r_N,F_N,u_N,state,fault,limits,late_us,step_us\n";
    recorder->path           = path;
    recorder->file           = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    int status               = recorder->file < 0 ? errno : write_whole(recorder->file, head, sizeof head - 1u);
    if (status == 0)
    {
        status = pthread_create(&recorder->thread, NULL, work, recorder);
    }
    if (status != 0)
    {
        (void)common_error_set(error, "--log %s: %s", path, strerror(status));
        if (recorder->file >= 0)
        {
            (void)close(recorder->file);
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

bool recorder_stop(recorder_t *recorder, uint64_t *written, uint64_t *dropped, common_error_t *error)
{
    atomic_store(&recorder->stops, true);
    (void)pthread_join(recorder->thread, NULL);
    *written         = atomic_load(&recorder->taken);
    *dropped         = recorder->dropped + atomic_load(&recorder->added) - *written;
    const int closed = close(recorder->file) == 0 ? 0 : errno;
    const int failed = recorder->failed != 0 ? recorder->failed : closed;
    free(recorder);
    return failed == 0 || common_error_set(error, "--log: %s", strerror(failed));
}
