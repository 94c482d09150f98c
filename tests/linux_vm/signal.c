// linux_vm_signal PID NAME VALUE_FILE [FILE NUMBER]: writes the number to the file, sends the signal, and prints how many ms it takes
// until the value says 0. It comes before the drive's processes, so that the end of one of them cannot hide the edge from it.

#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static double now_ms(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

int main(int count, char **arguments)
{
    static const struct
    {
        const char *name;
        int         number;
    } known[]  = {{"KILL", SIGKILL}, {"STOP", SIGSTOP}, {"TERM", SIGTERM}, {"INT", SIGINT}, {"NONE", 0}};
    int signal = -1;
    for (size_t i = 0; count >= 4 && i < sizeof known / sizeof known[0]; i++)
    {
        signal = strcmp(arguments[2], known[i].name) == 0 ? known[i].number : signal;
    }
    const int                file     = count >= 4 ? open(arguments[3], O_RDONLY) : -1;
    const int                other    = count == 6 ? open(arguments[4], O_WRONLY) : -1;
    const struct sched_param highest  = {.sched_priority = 99};
    const struct timespec    look     = {.tv_nsec = 100000};
    const double             start_ms = now_ms();
    char                     level    = '1';
    if (signal < 0 || file < 0 || (count == 6 && other < 0) || sched_setscheduler(0, SCHED_FIFO, &highest) != 0 ||
        (other >= 0 && write(other, arguments[5], strlen(arguments[5])) < 0) ||
        kill((pid_t)strtol(arguments[1], NULL, 10), signal) != 0)
    {
        perror("linux_vm_signal");
        return 1;
    }
    while (level != '0' && now_ms() < start_ms + 5000.0)
    {
        (void)nanosleep(&look, NULL);
        (void)!pread(file, &level, 1, 0);
    }
    (void)printf("%.1f\n", now_ms() - start_ms);
    return 0;
}
