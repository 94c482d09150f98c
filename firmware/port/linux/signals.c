#include "signals.h"

#include <pthread.h>
#include <stddef.h>
#include <unistd.h>

static volatile sig_atomic_t latest;

static bool is_fault(int signal)
{
    return signal == SIGSEGV || signal == SIGBUS || signal == SIGFPE || signal == SIGILL || signal == SIGTRAP ||
           signal == SIGSYS;
}

bool signals_stop(int signal, const siginfo_t *info)
{
    const bool is_harmless = signal == SIGCHLD || signal == SIGCONT || signal == SIGURG || signal == SIGWINCH;
    const bool is_own      = info->si_code <= 0 && info->si_pid == getpid();
    return !is_harmless && !(is_own && (signal == SIGPIPE || signal == SIGXFSZ));
}

static void take(int number, siginfo_t *info, void *context)
{
    (void)context;
    if (is_fault(number) && info->si_code > 0) // the kernel raised it: the instruction fails again and ends the process
    {
        (void)signal(number, SIG_DFL);
    }
    else if (signals_stop(number, info))
    {
        latest = number;
    }
}

void signals_take(void)
{
    const struct sigaction action = {.sa_sigaction = take, .sa_flags = SA_SIGINFO};
    sigset_t               none;
    for (int number = 1; number <= SIGRTMAX; number++)
    {
        (void)sigaction(number, &action, NULL); // refused for signals that cannot be caught
    }
    (void)sigemptyset(&none);
    (void)sigprocmask(SIG_SETMASK, &none, NULL);
}

int signals_latest(void)
{
    return latest;
}

void signals_block(sigset_t *before)
{
    sigset_t all;
    (void)sigfillset(&all);
    (void)pthread_sigmask(SIG_SETMASK, &all, before);
}
