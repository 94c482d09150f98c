#include "support/file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/// Reads to the end of `file`; null with errno set on failure.
static char *read_all(FILE *file, size_t *length)
{
    size_t capacity = 65536;
    char  *bytes    = malloc(capacity);
    *length         = 0;
    while (bytes != NULL)
    {
        *length += fread(bytes + *length, 1, capacity - *length - 1, file);
        if (ferror(file))
        {
            const int cause = errno;
            free(bytes);
            errno = cause;
            return NULL;
        }
        if (feof(file))
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

static size_t line_at(const char *bytes, size_t offset)
{
    size_t line = 1;
    for (size_t i = 0; i < offset; i++)
    {
        line += (bytes[i] == '\n') ? 1u : 0u;
    }
    return line;
}

char *sim_file_read(const char *path, size_t *length, sim_error_t *error)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL)
    {
        (void)sim_error_set(error, "%s: cannot be opened: %s", path, strerror(errno));
        return NULL;
    }
    char     *bytes = read_all(file, length);
    const int cause = errno;
    (void)fclose(file);
    if (bytes == NULL)
    {
        (void)sim_error_set(error, "%s: cannot be read: %s", path, strerror(cause));
        return NULL;
    }
    const char *zero = memchr(bytes, '\0', *length);
    if (zero != NULL)
    {
        (void)sim_error_set(error,
                            "%s:%zu: a zero byte: this is not a text file",
                            path,
                            line_at(bytes, (size_t)(zero - bytes)));
        free(bytes);
        return NULL;
    }
    if (strncmp(bytes, "\xEF\xBB\xBF", 3) == 0)
    {
        *length -= 3;
        memmove(bytes, bytes + 3, *length + 1);
    }
    return bytes;
}

bool sim_file_is_same(const char *a, const char *b)
{
    struct stat x, y;
    return stat(a, &x) == 0 && stat(b, &y) == 0 && x.st_dev == y.st_dev && x.st_ino == y.st_ino;
}
