#include "target/emulator.h"

#include "tribo_wire.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define MESSAGE_SIZE (4u * (TRIBO_WIRE_HEADER_WORDS + TRIBO_WIRE_WORDS_MAX))
#define SLICE_MS     50 // between two looks whether the process is still there

struct sim_emulator
{
    pid_t   process;     ///< 0: not there, or waited for
    char    folder[64];  ///< "": gone
    int     to_target;   ///< -1: not open
    int     from_target; ///< -1: not open
    int     log;         ///< -1: not open
    char    line[256];
    uint8_t message[MESSAGE_SIZE];
};

static double now_s(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

// --- the folder ----------------------------------------------------------------------------------------------------

static const char *const files[] = {TRIBO_WIRE_TO_TARGET, TRIBO_WIRE_FROM_TARGET, "log"};

static void path_of(char path[128], const sim_emulator_t *emulator, const char *name)
{
    (void)snprintf(path, 128, "%s/%s", emulator->folder, name);
}

/// Once both sides have everything open nothing of it is needed, so that nothing can be left behind.
static void remove_folder(sim_emulator_t *emulator)
{
    char path[128];
    if (emulator->folder[0] == '\0')
    {
        return;
    }
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++)
    {
        path_of(path, emulator, files[i]);
        (void)unlink(path);
    }
    (void)rmdir(emulator->folder);
    emulator->folder[0] = '\0';
}

static bool make_folder(sim_emulator_t *emulator, sim_error_t *error)
{
    const char *place  = getenv("TMPDIR");
    const int   length = snprintf(emulator->folder,
                                sizeof emulator->folder,
                                "%s/tribo.XXXXXX",
                                place != NULL && *place != '\0' ? place : "/tmp");
    if ((size_t)length >= sizeof emulator->folder)
    {
        (void)snprintf(emulator->folder, sizeof emulator->folder, "/tmp/tribo.XXXXXX");
    }
    if (mkdtemp(emulator->folder) == NULL)
    {
        const int reason    = errno;
        emulator->folder[0] = '\0';
        return sim_error_set(error, "no folder for the emulator: %s", strerror(reason));
    }
    char to[128];
    char from[128];
    char log[128];
    path_of(to, emulator, TRIBO_WIRE_TO_TARGET);
    path_of(from, emulator, TRIBO_WIRE_FROM_TARGET);
    path_of(log, emulator, "log");
    const bool made = mkfifo(to, 0600) == 0 && mkfifo(from, 0600) == 0;
    // Opened like this neither side waits for the other, and the end of the emulator shows as the end of its FIFO.
    emulator->to_target   = made ? open(to, O_RDWR | O_CLOEXEC | O_NONBLOCK) : -1;
    emulator->from_target = made ? open(from, O_RDONLY | O_CLOEXEC | O_NONBLOCK) : -1;
    emulator->log         = open(log, O_RDWR | O_CREAT | O_CLOEXEC | O_APPEND, 0600);
    if (emulator->to_target < 0 || emulator->from_target < 0 || emulator->log < 0)
    {
        return sim_error_set(error, "%s: %s", emulator->folder, strerror(errno));
    }
    return true;
}

// --- the process ---------------------------------------------------------------------------------------------------

/// The child's side of fork: never returns. Tells `report` why it could not start.
static void become(const sim_emulator_t *emulator, char *const *command, int report, pid_t parent)
{
    const int  nothing = open("/dev/null", O_RDONLY);
    const bool ready   = prctl(PR_SET_PDEATHSIG, SIGKILL) == 0 && getppid() == parent && nothing >= 0 &&
                       dup2(nothing, STDIN_FILENO) >= 0 && dup2(emulator->log, STDOUT_FILENO) >= 0 &&
                       dup2(emulator->log, STDERR_FILENO) >= 0 && chdir(emulator->folder) == 0;
    if (ready)
    {
        (void)signal(SIGPIPE, SIG_DFL);
        (void)execvp(command[0], command);
    }
    const int reason = errno;
    (void)!write(report, &reason, sizeof reason);
    _exit(127);
}

static bool start_process(sim_emulator_t *emulator, char *const *command, sim_error_t *error)
{
    int report[2];
    if (pipe(report) != 0)
    {
        return sim_error_set(error, "%s cannot be started: %s", command[0], strerror(errno));
    }
    (void)fcntl(report[1], F_SETFD, FD_CLOEXEC);
    const pid_t parent = getpid();
    emulator->process  = fork();
    if (emulator->process == 0)
    {
        become(emulator, command, report[1], parent);
    }
    int reason = errno;
    (void)close(report[1]);
    bool failed = emulator->process < 0;
    if (failed)
    {
        emulator->process = 0;
    }
    else
    {
        failed = read(report[0], &reason, sizeof reason) == (ssize_t)sizeof reason;
    }
    (void)close(report[0]);
    return !failed || sim_error_set(error, "%s cannot be started: %s", command[0], strerror(reason));
}

sim_emulator_t *sim_emulator_start(char *const *command, sim_error_t *error)
{
    sim_emulator_t *emulator = calloc(1, sizeof *emulator);
    if (emulator == NULL)
    {
        (void)sim_error_set(error, "out of memory");
        return NULL;
    }
    emulator->to_target   = -1;
    emulator->from_target = -1;
    emulator->log         = -1;
    if (!make_folder(emulator, error) || !start_process(emulator, command, error))
    {
        sim_emulator_stop(emulator);
        return NULL;
    }
    return emulator;
}

void sim_emulator_stop(sim_emulator_t *emulator)
{
    if (emulator == NULL)
    {
        return;
    }
    if (emulator->process > 0)
    {
        (void)kill(emulator->process, SIGKILL);
        (void)waitpid(emulator->process, NULL, 0);
    }
    remove_folder(emulator);
    const int open_files[] = {emulator->to_target, emulator->from_target, emulator->log};
    for (size_t i = 0; i < sizeof open_files / sizeof open_files[0]; i++)
    {
        if (open_files[i] >= 0)
        {
            (void)close(open_files[i]);
        }
    }
    free(emulator);
}

const char *sim_emulator_last_line(sim_emulator_t *emulator)
{
    char        tail[sizeof emulator->line];
    const off_t size  = lseek(emulator->log, 0, SEEK_END);
    const off_t start = size > (off_t)sizeof tail - 1 ? size - ((off_t)sizeof tail - 1) : 0;
    ssize_t     count = pread(emulator->log, tail, sizeof tail - 1, start);
    while (count > 0 && (tail[count - 1] == '\n' || tail[count - 1] == '\r'))
    {
        count--;
    }
    tail[count > 0 ? count : 0] = '\0';
    const char *newline         = strrchr(tail, '\n');
    (void)snprintf(emulator->line, sizeof emulator->line, "%s", newline != NULL ? newline + 1 : tail);
    return emulator->line;
}

/// True once the process has ended, with its status.
static bool has_ended(sim_emulator_t *emulator, int *status)
{
    if (waitpid(emulator->process, status, WNOHANG) != emulator->process)
    {
        return false;
    }
    emulator->process = 0;
    return true;
}

static bool tell_the_end(sim_emulator_t *emulator, int status, sim_error_t *error)
{
    const char *line = sim_emulator_last_line(emulator);
    const char *dash = *line != '\0' ? ": " : "";
    return WIFSIGNALED(status)
               ? sim_error_set(error, "the emulator was ended by signal %d%s%s", WTERMSIG(status), dash, line)
               : sim_error_set(error, "the emulator ended with status %d%s%s", WEXITSTATUS(status), dash, line);
}

bool sim_emulator_wait(sim_emulator_t *emulator, sim_error_t *error)
{
    const double deadline_s = now_s() + SIM_EMULATOR_TIMEOUT_S;
    int          status     = 0;
    while (!has_ended(emulator, &status))
    {
        if (now_s() > deadline_s)
        {
            return sim_error_set(error, "the emulator does not end");
        }
        (void)poll(NULL, 0, 5);
    }
    return (WIFEXITED(status) && WEXITSTATUS(status) == 0) || tell_the_end(emulator, status, error);
}

// --- messages ------------------------------------------------------------------------------------------------------

static void put_word(uint8_t *bytes, uint32_t word)
{
    for (unsigned i = 0; i < 4u; i++)
    {
        bytes[i] = (uint8_t)(word >> (8u * i));
    }
}

static uint32_t get_word(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

bool sim_emulator_send(sim_emulator_t *emulator,
                       uint32_t        kind,
                       const uint32_t *words,
                       uint32_t        count,
                       sim_error_t    *error)
{
    put_word(emulator->message, kind);
    put_word(emulator->message + 4, count);
    for (uint32_t i = 0; i < count; i++)
    {
        put_word(emulator->message + 4u * (TRIBO_WIRE_HEADER_WORDS + i), words[i]);
    }
    // One message at most is in the FIFO, which takes far more, so that this never waits.
    const size_t size = 4u * (TRIBO_WIRE_HEADER_WORDS + (size_t)count);
    return write(emulator->to_target, emulator->message, size) == (ssize_t)size ||
           sim_error_set(error, "the emulator does not take what it is sent");
}

/// Waits until there is something to read.
static bool wait_for_more(sim_emulator_t *emulator, double deadline_s, sim_error_t *error)
{
    struct pollfd wanted = {.fd = emulator->from_target, .events = POLLIN};
    while (poll(&wanted, 1, SLICE_MS) <= 0 || (wanted.revents & POLLIN) == 0)
    {
        int status = 0;
        if (has_ended(emulator, &status))
        {
            return tell_the_end(emulator, status, error);
        }
        if (now_s() > deadline_s)
        {
            return sim_error_set(error, "the emulator has not answered for %d s", SIM_EMULATOR_TIMEOUT_S);
        }
        if ((wanted.revents & POLLHUP) != 0)
        {
            (void)poll(NULL, 0, 1); // closed, but not ended yet
        }
    }
    return true;
}

static bool read_bytes(sim_emulator_t *emulator, size_t size, sim_error_t *error)
{
    const double deadline_s = now_s() + SIM_EMULATOR_TIMEOUT_S;
    size_t       have       = 0;
    while (have < size)
    {
        const ssize_t count = read(emulator->from_target, emulator->message + have, size - have);
        if (count > 0)
        {
            have += (size_t)count;
        }
        else if (!wait_for_more(emulator, deadline_s, error))
        {
            return false;
        }
    }
    return true;
}

bool sim_emulator_receive(sim_emulator_t *emulator, uint32_t kind, uint32_t *words, uint32_t count, sim_error_t *error)
{
    const size_t size = 4u * (TRIBO_WIRE_HEADER_WORDS + (size_t)count);
    if (size > MESSAGE_SIZE || !read_bytes(emulator, size, error))
    {
        return false;
    }
    if (get_word(emulator->message) != kind || get_word(emulator->message + 4) != count)
    {
        return sim_error_set(error, "the emulator's program does not speak this program's language");
    }
    for (uint32_t i = 0; i < count; i++)
    {
        words[i] = get_word(emulator->message + 4u * (TRIBO_WIRE_HEADER_WORDS + i));
    }
    remove_folder(emulator);
    return true;
}
