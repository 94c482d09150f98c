#include "recorder.h"

#include "realtime.h"
#include "signals.h"
#include "support/output_file.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define WAKE_NS    20000000
#define WAKE_MS    20
#define PIPE_NS    INT64_C(1000000000) ///< longest wait at the end for a pipe that accepts nothing ...
#define ABANDON_NS INT64_C(2000000000) ///< ... or for a disk, which keeps the thread

#define ROW_BYTES  192u ///< more bytes than a row has
#define PART_BYTES 16384u

struct recorder
{
    recorder_row_t       rows[RECORDER_ROWS];
    atomic_uint_fast64_t added, taken; ///< rows added by the tick, and taken by the thread
    atomic_bool          stops, has_ended;
    atomic_int_fast64_t  moved_ns; ///< when the file last took some bytes, or the end began
    uint64_t             dropped;  ///< rows dropped; only the tick writes this
    const char          *path;
    int                  file;     ///< -1: not open yet, and there are no rows
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

/// Returns false if the end has begun and the file has accepted nothing for too long.
static bool wait_for_room(recorder_t *recorder)
{
    struct pollfd room = {.fd = recorder->file, .events = POLLOUT};
    (void)poll(&room, 1, WAKE_MS);
    return !atomic_load(&recorder->stops) || realtime_now_ns() - atomic_load(&recorder->moved_ns) < PIPE_NS;
}

/// Writes all bytes or, if the disk accepted only a part, none, so that the file ends with a whole row. A target that cannot be
/// truncated is not a file.
static int write_whole(recorder_t *recorder, const char *text, size_t length)
{
    const int file   = recorder->file;
    size_t    done   = 0;
    int       failed = 0;
    while (done < length && failed == 0)
    {
        const ssize_t part = write(file, text + done, length - done);
        if (part >= 0)
        {
            done += (size_t)part;
            atomic_store(&recorder->moved_ns, realtime_now_ns());
        }
        else if (errno != EAGAIN || !wait_for_room(recorder))
        {
            failed = errno == EAGAIN ? ETIMEDOUT : errno; // no one reads the pipe
        }
    }
    if (failed != 0 && done > 0u)
    {
        const off_t end = lseek(file, 0, SEEK_CUR);
        (void)!(end >= 0 && ftruncate(file, end - (off_t)done) == 0 && lseek(file, end - (off_t)done, SEEK_SET) >= 0);
    }
    return failed;
}

/// Reports a failure when it happens. The drive goes on, and rows are dropped if there is no room until the disk accepts them.
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
        failed = write_whole(recorder, text, length);
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
    atomic_store(&recorder->has_ended, true);
    return NULL;
}

static int start_thread(recorder_t *recorder)
{
    sigset_t before;
    signals_block(&before);
    const int status = pthread_create(&recorder->thread, NULL, work, recorder);
    (void)pthread_sigmask(SIG_SETMASK, &before, NULL);
    return status;
}

recorder_t *recorder_start(const char *path, common_error_t *error)
{
    recorder_t *recorder = calloc(1, sizeof *recorder);
    if (recorder == NULL)
    {
        (void)common_error_set(error, "out of memory");
        return NULL;
    }
    recorder->path   = path;
    recorder->file   = -1;
    const int status = start_thread(recorder);
    if (status != 0)
    {
        (void)common_error_set(error, "the thread of --log cannot be started: %s", strerror(status));
        free(recorder);
        return NULL;
    }
    return recorder;
}

/// Returns whether a path of this descriptor would not open what it has: a file would be written from its beginning, where a shell
/// appends to it; a socket has no path; and what cannot be written would be.
static bool needs_copy(int descriptor)
{
    struct stat status;
    return fstat(descriptor, &status) != 0 || S_ISREG(status.st_mode) || S_ISSOCK(status.st_mode) ||
           (fcntl(descriptor, F_GETFL) & O_ACCMODE) == O_RDONLY;
}

/// Opens the path of --log. A write to a pipe does not wait then, which for a copy others would notice.
static int open_path(const char *path)
{
    const int descriptor = common_output_descriptor(path);
    return descriptor >= 0 && needs_copy(descriptor)
               ? fcntl(descriptor, F_DUPFD_CLOEXEC, STDERR_FILENO + 1)
               : open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NONBLOCK, 0666);
}

bool recorder_open(recorder_t *recorder, common_error_t *error)
{
    static const char head[] = "t_s,r_N,F_N,u_N,state,fault,limits,late_us,step_us\n";
    if (recorder == NULL)
    {
        return true;
    }
    recorder->file     = open_path(recorder->path);
    const int  status  = recorder->file < 0 ? errno : write_whole(recorder, head, sizeof head - 1u);
    const bool is_pipe = status == ENXIO; // a pipe is opened without waiting for its reader
    return status == 0 || common_error_set(error,
                                           "--log %s: %s",
                                           recorder->path,
                                           is_pipe ? "this pipe has no reader" : strerror(status));
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

/// Ends the thread. Returns false if the disk accepts nothing and the thread waits for it.
static bool wait_for_end(recorder_t *recorder)
{
    atomic_store(&recorder->moved_ns, realtime_now_ns());
    atomic_store(&recorder->stops, true);
    while (!atomic_load(&recorder->has_ended) && realtime_now_ns() - atomic_load(&recorder->moved_ns) < ABANDON_NS)
    {
        (void)realtime_sleep_until(realtime_now_ns() + WAKE_NS / 10);
    }
    return atomic_load(&recorder->has_ended) && pthread_join(recorder->thread, NULL) == 0;
}

bool recorder_stop(recorder_t *recorder, uint64_t *written, uint64_t *dropped, common_error_t *error)
{
    const bool has_ended = wait_for_end(recorder);
    *written             = atomic_load(&recorder->taken);
    *dropped             = recorder->dropped + atomic_load(&recorder->added) - *written;
    if (!has_ended)
    {
        return common_error_set(error, "--log: the disk accepts no more rows"); // the thread still uses the recorder
    }
    const int closed = close(recorder->file) == 0 ? 0 : errno;
    const int failed = recorder->failed != 0 ? recorder->failed : closed;
    free(recorder);
    return failed == 0 || common_error_set(error, "--log: %s", strerror(failed));
}
