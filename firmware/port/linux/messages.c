#include "messages.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

static bool          is_socket;
static int           file = STDERR_FILENO;
static unsigned long dropped;

/// Writes without waiting, even if standard error could not be opened anew.
static ssize_t write_now(const char *text, size_t size)
{
    struct pollfd room = {.fd = file, .events = POLLOUT};
    if (poll(&room, 1, 0) <= 0)
    {
        return -1;
    }
    return is_socket ? send(file, text, size, MSG_DONTWAIT | MSG_NOSIGNAL) : write(file, text, size);
}

/// The write function of the stream. It accepts everything, even if it must drop it.
static ssize_t put(void *context, const char *text, size_t size)
{
    (void)context;
    char      missed[64];
    const int length =
        dropped > 0u ? snprintf(missed, sizeof missed, "%lu messages dropped: no room on standard error\n", dropped)
                     : 0;
    if (length > 0 && write_now(missed, (size_t)length) > 0)
    {
        dropped = 0;
    }
    if (dropped > 0u || write_now(text, size) != (ssize_t)size)
    {
        dropped++;
    }
    return (ssize_t)size;
}

/// Pipes and terminals are opened anew, because whether a write waits is a property of the open file, which other processes
/// share.
static void open_again(void)
{
    struct stat is;
    if (fstat(STDERR_FILENO, &is) != 0)
    {
        return;
    }
    is_socket = S_ISSOCK(is.st_mode);
    if (S_ISFIFO(is.st_mode) || S_ISCHR(is.st_mode))
    {
        const int again = open("/proc/self/fd/2", O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
        file            = again >= 0 ? again : STDERR_FILENO;
    }
}

void messages_begin(void)
{
    static char                 line[512];
    const cookie_io_functions_t functions = {.write = put};
    FILE *const                 stream    = fopencookie(NULL, "w", functions);
    (void)signal(SIGPIPE, SIG_IGN);
    open_again();
    if (stream != NULL && setvbuf(stream, line, _IOLBF, sizeof line) == 0)
    {
        stderr = stream;
    }
}
