#include "support/file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/// Reads to the end of `file`, but at most max + 1 bytes. Returns null with errno set on failure.
static char *read_up_to(FILE *file, size_t max, size_t *length)
{
    size_t capacity = 65536;
    char  *bytes    = malloc(capacity);
    *length         = 0;
    while (bytes != NULL)
    {
        *length += fread(bytes + *length, 1, capacity - *length - 1, file);
        if (ferror(file))
        {
            free(bytes);
            return NULL;
        }
        if (feof(file) || *length > max)
        {
            bytes[*length] = '\0';
            return bytes;
        }
        capacity *= 2;
        char *larger = realloc(bytes, capacity);
        if (larger == NULL)
        {
            free(bytes);
        }
        bytes = larger;
    }
    return NULL;
}

/// Returns the name of an encoding of wide characters, found by a byte order mark or by a first character of ASCII;
/// otherwise null.
static const char *wide_coding(const char *bytes, size_t length)
{
    static const char marks[][4] = {{'\xff', '\xfe', 0, 0}, {0, 0, '\xfe', '\xff'}, {'\xff', '\xfe'}, {'\xfe', '\xff'}};
    for (size_t i = 0; i < sizeof marks / sizeof marks[0]; i++)
    {
        const size_t size = i < 2 ? 4 : 2;
        if (length >= size && memcmp(bytes, marks[i], size) == 0)
        {
            return size == 4 ? "UTF-32" : "UTF-16";
        }
    }
    const bool is_pair = length >= 4 && (bytes[0] == 0) != (bytes[1] == 0) && (bytes[0] == 0) == (bytes[2] == 0) &&
                         (bytes[1] == 0) == (bytes[3] == 0);
    return is_pair ? "UTF-16" : NULL;
}

/// Returns true if these bytes are text; otherwise `error` gives the reason.
static bool check_text(const char *bytes, size_t length, size_t max, const char *path, common_error_t *error)
{
    const char *coding = wide_coding(bytes, length);
    if (coding != NULL)
    {
        return common_error_set(error, "%s: is %s text; save it as UTF-8", path, coding);
    }
    const char *zero = memchr(bytes, '\0', length);
    if (zero != NULL)
    {
        size_t line = 1;
        for (const char *p = bytes; p < zero; p++)
        {
            line += (*p == '\n') ? 1u : 0u;
        }
        return common_error_set(error, "%s:%zu: a zero byte: this is not a text file", path, line);
    }
    return length <= max ||
           common_error_set(error, "%s: is larger than %zu KB, the limit for this file", path, max / 1024);
}

char *common_file_read(const char *path, size_t max, common_error_t *error)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL)
    {
        (void)common_error_set(error, "%s: cannot be opened: %s", path, strerror(errno));
        return NULL;
    }
    size_t length = 0;
    char  *bytes  = read_up_to(file, max, &length);
    if (bytes == NULL)
    {
        (void)common_error_set(error, "%s: cannot be read: %s", path, strerror(errno));
    }
    (void)fclose(file);
    if (bytes != NULL && !check_text(bytes, length, max, path, error))
    {
        free(bytes);
        return NULL;
    }
    if (bytes != NULL && strncmp(bytes, "\xEF\xBB\xBF", 3) == 0)
    {
        memmove(bytes, bytes + 3, length - 2);
    }
    return bytes;
}

bool common_file_exists(const char *path)
{
    return access(path, F_OK) == 0 || (errno != ENOENT && errno != ENOTDIR);
}

bool common_file_is_same(const char *a, const char *b)
{
    struct stat x, y;
    return stat(a, &x) == 0 && stat(b, &y) == 0 && x.st_dev == y.st_dev && x.st_ino == y.st_ino;
}

bool common_file_check_result(const char *result, const char *const *inputs, size_t count, common_error_t *error)
{
    for (size_t i = 0; i < count; i++)
    {
        if (inputs[i] != NULL && common_file_is_same(result, inputs[i]))
        {
            return common_error_set(error, "%s: cannot be written: this run reads it", result);
        }
    }
    return true;
}
