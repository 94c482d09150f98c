#include "supervisor.h"

#include "realtime.h"

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

#define LOOK_NS 2000000 ///< how often the supervisor looks

struct heart
{
    atomic_uint_fast32_t beats;
};

void heart_beat(heart_t *heart)
{
    (void)atomic_fetch_add_explicit(&heart->beats, 1u, memory_order_relaxed);
}

void heart_rest(heart_t *heart)
{
    atomic_store_explicit(&heart->beats, 0u, memory_order_relaxed);
}

static void tell_watchdog(int watchdog, char what)
{
    if (watchdog >= 0)
    {
        (void)!write(watchdog, &what, 1);
    }
}

/// A driver may take another timeout than it is given, and say so.
static bool set_timeout(int watchdog, const supervisor_config_t *config, common_error_t *error)
{
    const int requested = (int)config->watchdog_s;
    int       given     = requested;
    int       taken     = 0;
    if (ioctl(watchdog, WDIOC_SETTIMEOUT, &given) != 0 || ioctl(watchdog, WDIOC_GETTIMEOUT, &taken) != 0)
    {
        return common_error_set(error,
                                "watchdog: %s: takes no timeout of %d s (watchdog_s): %s",
                                config->watchdog,
                                requested,
                                strerror(errno));
    }
    return taken == requested || common_error_set(error,
                                                  "watchdog_s: %d: %s has a timeout of %d s in its place",
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

/// One killall does not take both processes. What ps shows are the process's arguments, in place; messages keep the program's name.
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

/// Until the loop's process ends or its heart stops. Returns its exit status as supervisor_run does.
static int watch(const supervisor_config_t *config,
                 const heart_t             *heart,
                 pid_t                      loop,
                 const sigset_t            *signals,
                 int                        watchdog)
{
    const struct timespec look      = {.tv_nsec = LOOK_NS};
    const uint64_t        looks     = config->heartbeat_ms * 1000000u / LOOK_NS + 1u;
    uint_fast32_t         beats     = 0;
    uint64_t              quiet     = 0; ///< looks without a beat
    int                   status    = 0;
    bool                  is_killed = false;
    while (waitpid(loop, &status, WNOHANG) != loop)
    {
        const int signal = sigtimedwait(signals, NULL, &look);
        if (signal == SIGINT || signal == SIGTERM)
        {
            (void)kill(loop, signal);
        }
        const uint_fast32_t now = atomic_load_explicit(&heart->beats, memory_order_relaxed);
        quiet                   = now == 0u || now != beats ? 0u : quiet + (signal < 0);
        beats                   = now;
        if (quiet < looks)
        {
            tell_watchdog(watchdog, '.');
        }
        else if (!is_killed)
        {
            config->off(config->context);
            (void)fprintf(stderr,
                          "%s: no heartbeat for %llu ms, stopped\n",
                          program_invocation_short_name,
                          (unsigned long long)config->heartbeat_ms);
            (void)kill(loop, SIGKILL);
            is_killed = true;
        }
    }
    config->off(config->context);
    if (WIFSIGNALED(status) && !is_killed)
    {
        (void)fprintf(stderr,
                      "%s: the loop's process was ended by signal %d, stopped\n",
                      program_invocation_short_name,
                      WTERMSIG(status));
    }
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

static int run_loop(int (*loop)(void *context, heart_t *heart),
                    void           *context,
                    heart_t        *heart,
                    pid_t           supervisor,
                    const sigset_t *before)
{
    // Without its supervisor the loop stops like for any SIGTERM.
    (void)prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != supervisor)
    {
        return 1;
    }
    (void)sigprocmask(SIG_SETMASK, before, NULL);
    const int status = loop(context, heart);
    (void)fflush(NULL);
    return status;
}

/// The two processes. Returns as supervisor_run does.
static int run_both(const supervisor_config_t *config,
                    int (*loop)(void *context, heart_t *heart),
                    void           *context,
                    heart_t        *heart,
                    int             watchdog,
                    common_error_t *error)
{
    sigset_t signals;
    sigset_t before;
    (void)sigemptyset(&signals);
    (void)sigaddset(&signals, SIGCHLD);
    (void)sigaddset(&signals, SIGINT);
    (void)sigaddset(&signals, SIGTERM);
    (void)sigprocmask(SIG_BLOCK, &signals, &before);
    (void)fflush(NULL); // or both would write what is left
    const pid_t supervisor = getpid();
    const pid_t process    = fork();
    if (process == 0)
    {
        _exit(run_loop(loop, context, heart, supervisor, &before));
    }
    int status = -1;
    if (process < 0)
    {
        (void)common_error_set(error, "no process for the loop: %s", strerror(errno));
    }
    else
    {
        take_name();
        // Only now, as the loop would inherit it. Without the privileges the loop says so.
        common_error_t          refused   = {""};
        const realtime_config_t real_time = {.priority = config->priority, .cpu = -1};
        (void)realtime_enter(&real_time, &refused);
        status = watch(config, heart, process, &signals, watchdog);
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
        (void)common_error_set(error, "no memory for a heartbeat: %s", strerror(errno));
    }
    else
    {
        atomic_init(&heart->beats, 0u);
        status = run_both(config, loop, context, heart, watchdog, error);
        (void)munmap(heart, sizeof *heart);
    }
    if (watchdog >= 0)
    {
        (void)close(watchdog);
    }
    return status;
}
