#include "target/emulator.h"

#include "support/clock.h"
#include "tribo_wire.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#define MESSAGE_SIZE (4u * (TRIBO_WIRE_HEADER_WORDS + TRIBO_WIRE_WORDS_MAX))
#define SLICE_MS     50  // time between checks for the end of the process
#define PIPE_FD_MIN  10  // keeps the pipes off the numbers that the child needs
#define MESSAGE_S    1   // longest time from the first to the last byte of a message
#define LINE_SIZE    256 // longest log line kept

typedef struct
{
    int read, write; ///< -1: not open
} pipe_t;

struct sim_emulator
{
    pid_t   process; ///< 0: no process, or its end is known
    pipe_t  to_target, from_target, log;
    char    line[LINE_SIZE];
    uint8_t message[MESSAGE_SIZE];
};

// --- pipes ---------------------------------------------------------------------------------------------------------

static void close_end(int *end)
{
    if (*end >= 0)
    {
        (void)close(*end);
        *end = -1;
    }
}

static void close_pipe(pipe_t *ends)
{
    close_end(&ends->read);
    close_end(&ends->write);
}

/// Opens a pipe whose ends close in any program started from here.
static bool open_pipe(pipe_t *ends)
{
    int raw[2];
    if (pipe(raw) != 0)
    {
        return false;
    }
    ends->read  = fcntl(raw[0], F_DUPFD_CLOEXEC, PIPE_FD_MIN);
    ends->write = fcntl(raw[1], F_DUPFD_CLOEXEC, PIPE_FD_MIN);
    (void)close(raw[0]);
    (void)close(raw[1]);
    return ends->read >= 0 && ends->write >= 0;
}

static bool do_not_block(int end)
{
    return fcntl(end, F_SETFL, O_NONBLOCK) == 0;
}

/// Opens the pipes. This program's ends do not block. The log does not block either: when it is full, the emulator's output
/// is dropped.
static bool open_pipes(sim_emulator_t *emulator, common_error_t *error)
{
    if (!open_pipe(&emulator->to_target) || !open_pipe(&emulator->from_target) || !open_pipe(&emulator->log) ||
        !do_not_block(emulator->to_target.write) || !do_not_block(emulator->from_target.read) ||
        !do_not_block(emulator->log.read) || !do_not_block(emulator->log.write))
    {
        (void)common_error_set(error, "pipes to the emulator cannot be opened: %s", strerror(errno));
        return false;
    }
    return true;
}

// --- the process ---------------------------------------------------------------------------------------------------

/// Runs the child's side of fork and never returns. If the command cannot start, the reason goes to `report`.
static void become(const sim_emulator_t *emulator, char *const *command, int report, pid_t parent)
{
    const int  nothing = open("/dev/null", O_RDONLY);
    const bool ready   = prctl(PR_SET_PDEATHSIG, SIGKILL) == 0 && getppid() == parent && nothing >= 0 &&
                       dup2(nothing, STDIN_FILENO) >= 0 && dup2(emulator->log.write, STDOUT_FILENO) >= 0 &&
                       dup2(emulator->log.write, STDERR_FILENO) >= 0 &&
                       dup2(emulator->to_target.read, TRIBO_WIRE_TO_TARGET_FD) >= 0 &&
                       dup2(emulator->from_target.write, TRIBO_WIRE_FROM_TARGET_FD) >= 0;
    if (ready)
    {
        (void)signal(SIGPIPE, SIG_DFL);
        (void)execvp(command[0], command);
    }
    const int reason = errno;
    (void)!write(report, &reason, sizeof reason);
    _exit(127);
}

static bool start_process(sim_emulator_t *emulator, char *const *command, common_error_t *error)
{
    pipe_t report = {.read = -1, .write = -1};
    if (!open_pipe(&report))
    {
        const int reason = errno;
        close_pipe(&report);
        return common_error_set(error, "%s cannot be started: %s", command[0], strerror(reason));
    }
    const pid_t parent = getpid();
    emulator->process  = fork();
    if (emulator->process == 0)
    {
        become(emulator, command, report.write, parent);
    }
    int reason = errno;
    close_end(&report.write);
    bool failed = emulator->process < 0;
    if (failed)
    {
        emulator->process = 0;
    }
    else
    {
        failed = read(report.read, &reason, sizeof reason) == (ssize_t)sizeof reason;
    }
    close_pipe(&report);
    close_end(&emulator->from_target.write); // only the emulator's copy is left, so its end closes the pipe
    return !failed || common_error_set(error, "%s cannot be started: %s", command[0], strerror(reason));
}

sim_emulator_t *sim_emulator_start(char *const *command, common_error_t *error)
{
    sim_emulator_t *emulator = calloc(1, sizeof *emulator);
    if (emulator == NULL)
    {
        (void)common_error_set(error, "out of memory");
        return NULL;
    }
    emulator->to_target = emulator->from_target = emulator->log = (pipe_t){.read = -1, .write = -1};
    if (!open_pipes(emulator, error) || !start_process(emulator, command, error))
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
    close_pipe(&emulator->to_target);
    close_pipe(&emulator->from_target);
    close_pipe(&emulator->log);
    free(emulator);
}

const char *sim_emulator_last_line(sim_emulator_t *emulator)
{
    char   byte;
    size_t length = 0;
    bool   ended  = true; // the next byte begins a line
    while (read(emulator->log.read, &byte, 1) == 1)
    {
        if (byte == '\n' || byte == '\r')
        {
            ended = true;
            continue;
        }
        length = ended ? 0 : length;
        ended  = false;
        if (length < LINE_SIZE - 1u)
        {
            emulator->line[length++] = byte;
            emulator->line[length]   = '\0';
        }
    }
    return emulator->line;
}

/// Returns true once the process has ended, with its status.
static bool has_ended(sim_emulator_t *emulator, int *status)
{
    if (waitpid(emulator->process, status, WNOHANG) != emulator->process)
    {
        return false;
    }
    emulator->process = 0;
    return true;
}

static bool report_end(sim_emulator_t *emulator, int status, common_error_t *error)
{
    const char *line = sim_emulator_last_line(emulator);
    const char *dash = *line != '\0' ? ": " : "";
    return WIFSIGNALED(status)
               ? common_error_set(error, "the emulator was ended by signal %d%s%s", WTERMSIG(status), dash, line)
               : common_error_set(error, "the emulator ended with status %d%s%s", WEXITSTATUS(status), dash, line);
}

bool sim_emulator_wait(sim_emulator_t *emulator, common_error_t *error)
{
    const double deadline_s = common_clock_s() + SIM_EMULATOR_TIMEOUT_S;
    int          status     = 0;
    while (!has_ended(emulator, &status))
    {
        if (common_clock_s() > deadline_s)
        {
            return common_error_set(error, "the emulator does not end");
        }
        (void)poll(NULL, 0, 5);
    }
    return (WIFEXITED(status) && WEXITSTATUS(status) == 0) || report_end(emulator, status, error);
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
                       common_error_t *error)
{
    put_word(emulator->message, kind);
    put_word(emulator->message + 4, count);
    for (uint32_t i = 0; i < count; i++)
    {
        put_word(emulator->message + 4u * (TRIBO_WIRE_HEADER_WORDS + i), words[i]);
    }
    // At most one message is in the pipe, which holds far more.
    const size_t size = 4u * (TRIBO_WIRE_HEADER_WORDS + (size_t)count);
    return write(emulator->to_target.write, emulator->message, size) == (ssize_t)size ||
           common_error_set(error, "the emulator does not read its messages");
}

static bool is_in_time(double deadline_s, bool begun, common_error_t *error)
{
    return common_clock_s() <= deadline_s ||
           (begun ? common_error_set(error, "the emulator has stopped within a message")
                  : common_error_set(error, "the emulator has not answered for %d s", SIM_EMULATOR_TIMEOUT_S));
}

/// Waits for the first bytes of a message, or for the rest of one that has `begun`: until bytes arrive, the emulator ends, or
/// `deadline_s` passes.
static bool wait_for_more(sim_emulator_t *emulator, double deadline_s, bool begun, common_error_t *error)
{
    struct pollfd answer = {.fd = emulator->from_target.read, .events = POLLIN};
    while (poll(&answer, 1, SLICE_MS) <= 0 || (answer.revents & POLLIN) == 0)
    {
        int status = 0;
        if (has_ended(emulator, &status))
        {
            return report_end(emulator, status, error);
        }
        if (!is_in_time(deadline_s, begun, error))
        {
            return false;
        }
        if ((answer.revents & POLLHUP) != 0)
        {
            (void)poll(NULL, 0, 1); // the pipe is closed, but the process has not ended yet
        }
    }
    return is_in_time(deadline_s, begun, error);
}

/// The target writes a message at once, so bytes that trickle in do not extend the wait.
static bool read_bytes(sim_emulator_t *emulator, size_t size, common_error_t *error)
{
    double deadline_s = common_clock_s() + SIM_EMULATOR_TIMEOUT_S;
    size_t have       = 0;
    while (have < size)
    {
        const ssize_t count = read(emulator->from_target.read, emulator->message + have, size - have);
        if (count > 0)
        {
            deadline_s = have == 0 ? common_clock_s() + MESSAGE_S : deadline_s;
            have += (size_t)count;
        }
        if (have < size && !wait_for_more(emulator, deadline_s, have > 0, error))
        {
            return false;
        }
    }
    return true;
}

bool sim_emulator_receive(sim_emulator_t *emulator,
                          uint32_t        kind,
                          uint32_t       *words,
                          uint32_t        count,
                          common_error_t *error)
{
    const size_t size = 4u * (TRIBO_WIRE_HEADER_WORDS + (size_t)count);
    if (size > MESSAGE_SIZE || !read_bytes(emulator, size, error))
    {
        return false;
    }
    if (get_word(emulator->message) != kind || get_word(emulator->message + 4) != count)
    {
        return common_error_set(error, "the emulator's program sends messages of another kind or version");
    }
    for (uint32_t i = 0; i < count; i++)
    {
        words[i] = get_word(emulator->message + 4u * (TRIBO_WIRE_HEADER_WORDS + i));
    }
    return true;
}
