#include "text_file.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#define DIGITS_MAX 24
#define TRIALS     8 ///< a driver that waits is interrupted by every signal, even by one that stops nothing

static ssize_t read_text(int file, char *text, size_t size)
{
    ssize_t length = -1;
    errno          = EINTR;
    for (int trial = 0; trial < TRIALS && length < 0 && errno == EINTR; trial++)
    {
        length = pread(file, text, size, 0);
    }
    return length;
}

static ssize_t write_text(int file, const char *text, size_t size)
{
    ssize_t length = -1;
    errno          = EINTR;
    for (int trial = 0; trial < TRIALS && length < 0 && errno == EINTR; trial++)
    {
        length = pwrite(file, text, size, 0);
    }
    return length;
}

bool text_file_read(int file, int64_t *number)
{
    char          text[DIGITS_MAX + 1];
    const ssize_t length = read_text(file, text, DIGITS_MAX);
    if (length <= 0)
    {
        errno = length == 0 ? ENODATA : errno;
        return false;
    }
    text[length] = '\0';
    char *end;
    errno            = 0;
    *number          = strtoll(text, &end, 10);
    const bool whole = length < DIGITS_MAX && (*end == '\0' || *end == '\n' || *end == ' ');
    errno            = errno == 0 && (end == text || !whole) ? EINVAL : errno;
    return errno == 0;
}

bool text_file_write(int file, int64_t number)
{
    char      text[DIGITS_MAX + 1];
    const int length = snprintf(text, sizeof text, "%" PRId64 "\n", number);
    return write_text(file, text, (size_t)length) == length;
}
