/// Jobs on all cores: worker processes take the job numbers in turn, and the results return in order.
///
/// Processes, not threads: a crash or hang costs and reports only its own job.

#ifndef SIM_POOL_H
#define SIM_POOL_H

#include "support/error.h"

#include <stdint.h>

#define SIM_POOL_WORKERS_MAX 1024u

/// How a worker ended before its job did.
typedef enum
{
    SIM_POOL_CRASHED,
    SIM_POOL_TIMED_OUT
} sim_pool_loss_t;

typedef struct
{
    uint64_t first, end; ///< the jobs, `end` excluded
    unsigned workers;    ///< 0: one for each core
    double   timeout_s;  ///< of CPU time for a job
    void    *context;

    /// In a worker: the job's result as text, to be freed, and a number; null if there is no memory. Changes stay in the worker.
    char *(*work)(void *context, uint64_t job, double *number);

    /// The text of a job whose worker was lost; its number is 0.
    char *(*lost)(void *context, uint64_t job, sim_pool_loss_t how, int signal);

    /// Takes the results, job by job; false, with the error filled in, ends the pool.
    bool (*take)(void *context, uint64_t job, const char *text, double number, common_error_t *error);
} sim_pool_t;

unsigned sim_pool_cores(void);

/// Runs all jobs. The workers' CPU time counts as the children's (getrusage).
bool sim_pool_run(const sim_pool_t *pool, common_error_t *error);

#endif
