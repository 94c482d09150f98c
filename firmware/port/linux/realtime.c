#include "realtime.h"

#include <errno.h>
#include <inttypes.h>
#include <sched.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>

#define NS_PER_S 1000000000

void histogram_add(histogram_t *histogram, int64_t time_ns)
{
    unsigned bin = 0;
    while (bin + 1u < HISTOGRAM_BINS && time_ns >= (int64_t)1000 << bin)
    {
        bin++;
    }
    histogram->count[bin]++;
    histogram->total++;
    histogram->longest_ns = time_ns > histogram->longest_ns ? time_ns : histogram->longest_ns;
}

double histogram_quantile_us(const histogram_t *histogram, double part)
{
    uint64_t seen = 0;
    for (unsigned bin = 0; bin < HISTOGRAM_BINS; bin++)
    {
        seen += histogram->count[bin];
        if (seen > 0 && (double)seen >= part * (double)histogram->total)
        {
            return (double)((int64_t)1 << bin);
        }
    }
    return 0.0;
}

void histogram_print(const histogram_t *histogram, const char *name, FILE *stream)
{
    (void)fprintf(stream,
                  "%s: half below %g us, 99 %% below %g us, longest %.1f us;",
                  name,
                  histogram_quantile_us(histogram, 0.5),
                  histogram_quantile_us(histogram, 0.99),
                  (double)histogram->longest_ns / 1000.0);
    for (unsigned bin = 0; bin < HISTOGRAM_BINS; bin++)
    {
        if (histogram->count[bin] > 0u)
        {
            (void)fprintf(stream, " <%lld: %" PRIu64, 1LL << bin, histogram->count[bin]);
        }
    }
    (void)fputc('\n', stream);
}

bool realtime_check_cpu(int64_t cpu, common_error_t *error)
{
    cpu_set_t allowed;
    CPU_ZERO(&allowed);
    if (cpu < 0 || sched_getaffinity(0, sizeof allowed, &allowed) != 0 ||
        (cpu < CPU_SETSIZE && CPU_ISSET((size_t)cpu, &allowed)))
    {
        return true;
    }
    return common_error_set(error,
                            "realtime.cpu: value %lld: must be a CPU that this process may run on; it has %d",
                            (long long)cpu,
                            CPU_COUNT(&allowed));
}

static bool choose_cpu(int64_t cpu, common_error_t *error)
{
    cpu_set_t set;
    CPU_ZERO(&set);
    if (cpu < 0)
    {
        return true;
    }
    if (!realtime_check_cpu(cpu, error))
    {
        return false;
    }
    CPU_SET((size_t)cpu, &set);
    return sched_setaffinity(0, sizeof set, &set) == 0 ||
           common_error_set(error, "realtime.cpu: CPU %lld: %s", (long long)cpu, strerror(errno));
}

bool realtime_enter(const realtime_config_t *config, common_error_t *error)
{
    const struct sched_param parameters = {.sched_priority = (int)config->priority};
    if (!choose_cpu(config->cpu, error))
    {
        return false;
    }
    if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0)
    {
        return common_error_set(error, "memory cannot be locked: %s", strerror(errno));
    }
    return sched_setscheduler(0, SCHED_FIFO, &parameters) == 0 ||
           common_error_set(error, "realtime.priority: SCHED_FIFO %d: %s", parameters.sched_priority, strerror(errno));
}

int64_t realtime_now_ns(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * NS_PER_S + now.tv_nsec;
}

bool realtime_sleep_until(int64_t due_ns)
{
    const struct timespec due = {.tv_sec = due_ns / NS_PER_S, .tv_nsec = due_ns % NS_PER_S};
    return clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, NULL) == 0;
}
