#include "text_file.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#define DIGITS_MAX 24

bool text_file_read(int file, int64_t *number)
{
    char          text[DIGITS_MAX + 1];
    const ssize_t length = pread(file, text, DIGITS_MAX, 0);
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
    return pwrite(file, text, (size_t)length, 0) == length;
}
