#include "sweep/pool.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#define NO_JOB UINT64_MAX

/// In memory that the processes share.
typedef struct
{
    atomic_uint_least64_t next;
    atomic_uint_least64_t job[SIM_POOL_WORKERS_MAX]; ///< each worker's present job
} shared_t;

/// Precedes each result in the pipe.
typedef struct
{
    uint64_t job;
    uint64_t length;
    double   number;
} header_t;

typedef struct
{
    char  *text; ///< null: missing yet, or taken
    double number;
} result_t;

typedef struct
{
    pid_t  process; ///< 0: none
    int    pipe;    ///< to read from
    char  *bytes;   ///< of an incomplete result
    size_t length;
} worker_t;

typedef struct
{
    const sim_pool_t *pool;
    shared_t         *shared;
    worker_t         *worker;
    unsigned          workers;
    result_t         *result; ///< by job, counted from the first
    uint64_t          taken;
    common_error_t   *error;
} run_t;

unsigned sim_pool_cores(void)
{
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    return cores<1 ? 1u : cores>(long) SIM_POOL_WORKERS_MAX ? SIM_POOL_WORKERS_MAX : (unsigned)cores;
}

// --- in a worker ---------------------------------------------------------------------------------------------------

static bool write_all(int file, const void *bytes, size_t length)
{
    const char *next = bytes;
    while (length > 0)
    {
        const ssize_t written = write(file, next, length);
        if (written < 0 && errno != EINTR)
        {
            return false;
        }
        next += written > 0 ? written : 0;
        length -= written > 0 ? (size_t)written : 0;
    }
    return true;
}

/// SIGPROF ends the worker after this CPU time; 0: no limit.
static void limit_time(double time_s)
{
    struct itimerval timer = {.it_value = {.tv_sec = (time_t)time_s}};
    timer.it_value.tv_usec = (suseconds_t)(1e6 * (time_s - floor(time_s)));
    (void)setitimer(ITIMER_PROF, &timer, NULL);
}

static int work(const run_t *run, unsigned number, int pipe)
{
    const sim_pool_t *pool = run->pool;
    for (;;)
    {
        const uint64_t job = atomic_fetch_add(&run->shared->next, 1);
        if (job >= pool->end)
        {
            return EXIT_SUCCESS;
        }
        atomic_store(&run->shared->job[number], job);
        limit_time(pool->timeout_s);
        double measure = 0.0;
        char  *text    = pool->work(pool->context, job, &measure);
        limit_time(0.0);
        const header_t header = {.job = job, .length = text != NULL ? strlen(text) : 0, .number = measure};
        // The write fails once the program has ended.
        const bool ok = text != NULL && write_all(pipe, &header, sizeof header) && write_all(pipe, text, header.length);
        free(text);
        if (!ok)
        {
            return EXIT_FAILURE;
        }
        atomic_store(&run->shared->job[number], NO_JOB);
    }
}

// --- in the parent -------------------------------------------------------------------------------------------------

static bool start_worker(run_t *run, unsigned number)
{
    int ends[2];
    if (pipe(ends) != 0)
    {
        return common_error_set(run->error, "a worker cannot be started: %s", strerror(errno));
    }
    const pid_t process = fork();
    if (process == 0)
    {
        // A worker's write fails at the program's end only if no other worker holds the read end.
        for (unsigned i = 0; i < run->workers; i++)
        {
            if (run->worker[i].process != 0)
            {
                (void)close(run->worker[i].pipe);
            }
        }
        (void)close(ends[0]);
        _exit(work(run, number, ends[1]));
    }
    (void)close(ends[1]);
    if (process < 0)
    {
        (void)close(ends[0]);
        return common_error_set(run->error, "a worker cannot be started: %s", strerror(errno));
    }
    run->worker[number] = (worker_t){.process = process, .pipe = ends[0]};
    return true;
}

/// Hands on the available results in order.
static bool take_results(run_t *run)
{
    const sim_pool_t *pool = run->pool;
    while (pool->first + run->taken < pool->end && run->result[run->taken].text != NULL)
    {
        const result_t result   = run->result[run->taken];
        run->result[run->taken] = (result_t){.text = NULL};
        const bool ok = pool->take(pool->context, pool->first + run->taken, result.text, result.number, run->error);
        free(result.text);
        run->taken++;
        if (!ok)
        {
            return false;
        }
    }
    return true;
}

/// Moves whole results out of a worker's bytes.
static bool sort_results(run_t *run, worker_t *worker)
{
    header_t header;
    size_t   used = 0;
    while (worker->length - used >= sizeof header)
    {
        memcpy(&header, worker->bytes + used, sizeof header);
        if (worker->length - used - sizeof header < header.length)
        {
            break;
        }
        char *text = malloc(header.length + 1);
        if (text == NULL)
        {
            return common_error_set(run->error, "out of memory");
        }
        memcpy(text, worker->bytes + used + sizeof header, header.length);
        text[header.length]                        = '\0';
        run->result[header.job - run->pool->first] = (result_t){.text = text, .number = header.number};
        used += sizeof header + header.length;
    }
    if (used > 0)
    {
        memmove(worker->bytes, worker->bytes + used, worker->length - used);
        worker->length -= used;
    }
    return take_results(run);
}

/// A worker's pipe has ended: the worker is done, or was lost with its job.
static bool end_worker(run_t *run, unsigned number)
{
    const sim_pool_t *pool   = run->pool;
    worker_t         *worker = &run->worker[number];
    int               status = 0;
    while (waitpid(worker->process, &status, 0) < 0 && errno == EINTR)
    {
    }
    (void)close(worker->pipe);
    free(worker->bytes);
    *worker            = (worker_t){.process = 0};
    const uint64_t job = atomic_exchange(&run->shared->job[number], NO_JOB);
    if (WIFEXITED(status))
    {
        return WEXITSTATUS(status) == EXIT_SUCCESS || common_error_set(run->error, "out of memory");
    }
    const int signal = WTERMSIG(status);
    // The result may have arrived although its worker died before recording it.
    if (job != NO_JOB && job - pool->first >= run->taken && run->result[job - pool->first].text == NULL)
    {
        run->result[job - pool->first].text =
            pool->lost(pool->context, job, signal == SIGPROF ? SIM_POOL_TIMED_OUT : SIM_POOL_CRASHED, signal);
        if (run->result[job - pool->first].text == NULL)
        {
            return common_error_set(run->error, "out of memory");
        }
    }
    return start_worker(run, number) && take_results(run);
}

static bool read_worker(run_t *run, unsigned number)
{
    worker_t *worker = &run->worker[number];
    char      bytes[65536];
    ssize_t   length = read(worker->pipe, bytes, sizeof bytes);
    if (length < 0)
    {
        return errno == EINTR || common_error_set(run->error, "a worker cannot be read: %s", strerror(errno));
    }
    if (length == 0)
    {
        return end_worker(run, number);
    }
    char *larger = realloc(worker->bytes, worker->length + (size_t)length);
    if (larger == NULL)
    {
        return common_error_set(run->error, "out of memory");
    }
    worker->bytes = larger;
    memcpy(worker->bytes + worker->length, bytes, (size_t)length);
    worker->length += (size_t)length;
    return sort_results(run, worker);
}

/// Waits for results until no worker is left.
static bool serve(run_t *run)
{
    struct pollfd waiting[SIM_POOL_WORKERS_MAX];
    unsigned      number[SIM_POOL_WORKERS_MAX];
    for (;;)
    {
        nfds_t count = 0;
        for (unsigned i = 0; i < run->workers; i++)
        {
            if (run->worker[i].process != 0)
            {
                number[count]    = i;
                waiting[count++] = (struct pollfd){.fd = run->worker[i].pipe, .events = POLLIN};
            }
        }
        if (count == 0)
        {
            return true;
        }
        if (poll(waiting, count, -1) < 0 && errno != EINTR)
        {
            return common_error_set(run->error, "the workers cannot be waited for: %s", strerror(errno));
        }
        for (nfds_t i = 0; i < count; i++)
        {
            if (waiting[i].revents != 0 && !read_worker(run, number[i]))
            {
                return false;
            }
        }
    }
}

/// After an error: ends every worker.
static void end_all(run_t *run)
{
    for (unsigned i = 0; i < run->workers; i++)
    {
        worker_t *worker = &run->worker[i];
        if (worker->process != 0)
        {
            (void)kill(worker->process, SIGKILL);
            (void)waitpid(worker->process, NULL, 0);
            (void)close(worker->pipe);
        }
        free(worker->bytes);
    }
}

static bool run_all(run_t *run)
{
    const sim_pool_t *pool = run->pool;
    atomic_init(&run->shared->next, pool->first);
    bool ok = true;
    for (unsigned i = 0; ok && i < run->workers; i++)
    {
        atomic_init(&run->shared->job[i], NO_JOB);
        ok = start_worker(run, i);
    }
    ok = ok && serve(run);
    end_all(run);
    return ok;
}

bool sim_pool_run(const sim_pool_t *pool, common_error_t *error)
{
    const uint64_t jobs = pool->end - pool->first;
    run_t run = {.pool = pool, .error = error, .workers = pool->workers != 0 ? pool->workers : sim_pool_cores()};
    if (jobs == 0)
    {
        return true;
    }
    run.workers = run.workers > jobs ? (unsigned)jobs : run.workers;
    run.worker  = calloc(run.workers, sizeof *run.worker);
    run.result  = calloc(jobs, sizeof *run.result);
    run.shared  = mmap(NULL, sizeof *run.shared, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    bool ok     = run.worker != NULL && run.result != NULL && run.shared != MAP_FAILED;
    ok          = ok ? run_all(&run) : common_error_set(error, "out of memory");
    for (uint64_t i = 0; run.result != NULL && i < jobs; i++)
    {
        free(run.result[i].text);
    }
    free(run.result);
    free(run.worker);
    if (run.shared != MAP_FAILED)
    {
        (void)munmap(run.shared, sizeof *run.shared);
    }
    return ok;
}
