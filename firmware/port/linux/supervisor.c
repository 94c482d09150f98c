#include "supervisor.h"

#include "realtime.h"
#include "signals.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/watchdog.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define NS_PER_MS INT64_C(1000000)
#define LOOK_NS   (2 * NS_PER_MS) ///< how often the supervisor looks
#define END_NS    (SUPERVISOR_END_S * 1000 * NS_PER_MS)

#define PARTS 4 ///< least number of beats in a time without a look that shows a missing supervisor

struct heart
{
    atomic_uint_fast32_t beats, looks;
    atomic_bool          is_over;

    // State of the loop.
    uint_fast32_t looks_seen;
    int64_t       beat_ns, quiet_ns, quiet_max_ns;
};

/// Time in which the loop itself has not run does not count, because the supervisor may have waited for the same processor.
bool heart_beat(heart_t *heart)
{
    (void)atomic_fetch_add_explicit(&heart->beats, 1u, memory_order_relaxed);
    const uint_fast32_t looks = atomic_load_explicit(&heart->looks, memory_order_relaxed);
    const int64_t       now   = realtime_now_ns();
    const int64_t       most  = heart->quiet_max_ns / PARTS;
    const int64_t       since = now - heart->beat_ns < most ? now - heart->beat_ns : most;
    heart->quiet_ns           = looks != heart->looks_seen ? 0 : heart->quiet_ns + since;
    heart->looks_seen         = looks;
    heart->beat_ns            = now;
    return heart->quiet_ns < heart->quiet_max_ns;
}

void heart_rest(heart_t *heart)
{
    atomic_store(&heart->is_over, true);
}

static void tell_watchdog(int watchdog, char what)
{
    if (watchdog >= 0)
    {
        (void)!write(watchdog, &what, 1);
    }
}

/// Sets the timeout and reads it back, because a driver may choose another one.
static bool set_timeout(int watchdog, const supervisor_config_t *config, common_error_t *error)
{
    const int requested = (int)config->watchdog_s;
    int       given     = requested;
    int       taken     = 0;
    if (ioctl(watchdog, WDIOC_SETTIMEOUT, &given) != 0 || ioctl(watchdog, WDIOC_GETTIMEOUT, &taken) != 0)
    {
        return common_error_set(error,
                                "watchdog: %s: does not accept a timeout of %d s (watchdog_s): %s",
                                config->watchdog,
                                requested,
                                strerror(errno));
    }
    return taken == requested || common_error_set(error,
                                                  "watchdog_s: %d: %s uses a timeout of %d s instead",
                                                  requested,
                                                  config->watchdog,
                                                  taken);
}

/// The device stays armed if the program dies; "V" disarms it.
static int open_watchdog(const supervisor_config_t *config, common_error_t *error)
{
    if (config->watchdog == NULL)
    {
        return -1;
    }
    const int watchdog = open(config->watchdog, O_WRONLY | O_CLOEXEC);
    if (watchdog < 0)
    {
        (void)common_error_set(error, "watchdog: %s: %s", config->watchdog, strerror(errno));
    }
    else if (!set_timeout(watchdog, config, error))
    {
        tell_watchdog(watchdog, 'V');
        (void)close(watchdog);
        return -1;
    }
    return watchdog;
}

/// Renames the supervisor, so that one killall does not end both processes. ps shows a process's arguments, which are
/// overwritten in place; messages keep the program's name.
static void take_name(void)
{
    static char  own[64];
    char        *name = program_invocation_short_name;
    const size_t room = strlen(name);
    (void)prctl(PR_SET_NAME, SUPERVISOR_NAME);
    if (name != own)
    {
        (void)snprintf(own, sizeof own, "%s", name);
        program_invocation_short_name = own;
        memset(name, 0, room);
        (void)snprintf(name, room + 1u, "%s", SUPERVISOR_NAME);
    }
}

typedef struct
{
    pid_t         loop;
    uint_fast32_t beats;
    int64_t       look_ns;   ///< time of the last look
    int64_t       quiet_ns;  ///< time without a beat
    int64_t       ending_ns; ///< time since the loop was requested to end, or rests
    bool          is_asked, is_killed;
} watch_t;

static void kill_loop(const supervisor_config_t *config, watch_t *watch, const char *why, uint64_t ms)
{
    config->off(config->context);
    (void)fprintf(stderr, "%s: %s for %llu ms, stopped\n", program_invocation_short_name, why, (unsigned long long)ms);
    (void)kill(watch->loop, SIGKILL);
    watch->is_killed = true;
}

/// Checks the heartbeat, after a wait that a signal may have cut short. Returns false if the heart does not beat. A longer
/// wait than LOOK_NS counts as one, because the loop may not have run either.
static bool look(const supervisor_config_t *config, heart_t *heart, watch_t *watch)
{
    const int64_t       most    = (int64_t)config->heartbeat_ms * NS_PER_MS;
    const bool          is_over = atomic_load(&heart->is_over);
    const uint_fast32_t beats   = atomic_load_explicit(&heart->beats, memory_order_relaxed);
    const int64_t       now     = realtime_now_ns();
    const int64_t       since   = now - watch->look_ns < LOOK_NS ? now - watch->look_ns : LOOK_NS;
    watch->quiet_ns             = is_over || beats == 0u || beats != watch->beats ? 0 : watch->quiet_ns + since;
    watch->ending_ns += watch->is_asked || is_over ? since : 0;
    watch->beats   = beats;
    watch->look_ns = now;
    (void)atomic_fetch_add_explicit(&heart->looks, 1u, memory_order_relaxed);
    if (!watch->is_killed && watch->quiet_ns > most)
    {
        kill_loop(config, watch, "no heartbeat", config->heartbeat_ms);
    }
    else if (!watch->is_killed && watch->ending_ns >= END_NS)
    {
        kill_loop(config, watch, "the loop's process does not end", SUPERVISOR_END_S * 1000u);
    }
    return watch->quiet_ns <= most;
}

/// Watches until the loop's process ends or its heart stops. Returns its exit status as supervisor_run does.
static int watch_loop(const supervisor_config_t *config, heart_t *heart, pid_t loop, int watchdog)
{
    const struct timespec pause  = {.tv_nsec = LOOK_NS};
    watch_t               watch  = {.loop = loop, .look_ns = realtime_now_ns()};
    int                   status = 0;
    sigset_t              all;
    (void)sigfillset(&all);
    while (waitpid(loop, &status, WNOHANG) == 0)
    {
        siginfo_t info;
        const int signal = sigtimedwait(&all, &info, &pause);
        if (signal > 0 && signals_stop(signal, &info))
        {
            watch.is_asked = true;
            (void)kill(loop, SIGTERM);
        }
        if (look(config, heart, &watch))
        {
            tell_watchdog(watchdog, '.');
        }
    }
    config->off(config->context);
    if (WIFSIGNALED(status) && !watch.is_killed)
    {
        (void)fprintf(stderr,
                      "%s: the loop's process was ended by signal %d, stopped\n",
                      program_invocation_short_name,
                      WTERMSIG(status));
    }
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

static int run_loop(int (*loop)(void *context, heart_t *heart), void *context, heart_t *heart, pid_t supervisor)
{
    (void)setsid();
    signals_take();
    // Without its supervisor the loop stops, as for any SIGTERM.
    (void)prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != supervisor)
    {
        return 1;
    }
    const int status = loop(context, heart);
    (void)fflush(NULL);
    return status;
}

/// Runs the two processes. Returns what supervisor_run returns.
static int run_both(const supervisor_config_t *config,
                    int (*loop)(void *context, heart_t *heart),
                    void           *context,
                    heart_t        *heart,
                    int             watchdog,
                    common_error_t *error)
{
    sigset_t before;
    signals_block(&before);
    (void)signal(SIGCHLD, SIG_DFL); // otherwise the kernel would not report the loop's end
    (void)fflush(NULL);             // otherwise both processes would write the buffered output
    const pid_t supervisor = getpid();
    const pid_t process    = fork();
    if (process == 0)
    {
        _exit(run_loop(loop, context, heart, supervisor));
    }
    int status = -1;
    if (process < 0)
    {
        (void)common_error_set(error, "the loop's process cannot be created: %s", strerror(errno));
    }
    else
    {
        take_name();
        // Set the priority only now, because the loop would inherit it. Without the privileges the loop reports that.
        common_error_t          refused   = {""};
        const realtime_config_t real_time = {.priority = config->priority, .cpu = -1};
        (void)realtime_enter(&real_time, &refused);
        status = watch_loop(config, heart, process, watchdog);
        tell_watchdog(watchdog, 'V');
    }
    (void)sigprocmask(SIG_SETMASK, &before, NULL);
    return status;
}

int supervisor_run(const supervisor_config_t *config,
                   int (*loop)(void *context, heart_t *heart),
                   void           *context,
                   common_error_t *error)
{
    const int watchdog = open_watchdog(config, error);
    if (config->watchdog != NULL && watchdog < 0)
    {
        return -1;
    }
    int      status = -1;
    heart_t *heart  = mmap(NULL, sizeof *heart, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (heart == MAP_FAILED)
    {
        (void)common_error_set(error, "memory for the heartbeat cannot be allocated: %s", strerror(errno));
    }
    else
    {
        *heart = (heart_t){.quiet_max_ns = (int64_t)config->heartbeat_ms * NS_PER_MS};
        status = run_both(config, loop, context, heart, watchdog, error);
        (void)munmap(heart, sizeof *heart);
    }
    if (watchdog >= 0)
    {
        (void)close(watchdog);
    }
    return status;
}
