#include "sweep/rows.h"

#include "support/file.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define BYTES_MAX (1u << 31u)

uint64_t sim_shard_rows(const sim_shard_t *shard, uint64_t rows)
{
    return (rows + shard->count - 1 - shard->index) / shard->count;
}

static uint64_t number_of(const sim_shard_t *shard, uint64_t place)
{
    return place * shard->count + shard->index;
}

static void write_start(const sim_rows_t *file, uint64_t place, char text[64])
{
    (void)snprintf(text, 64, "%08" PRIx32 ",%" PRIu64 ",", file->id, number_of(&file->shard, place));
}

/// Checks the lines of a file, with 0 for each end of line, up to `end`. Returns the number of rows, or -1.
static int64_t check_lines(const sim_rows_t *file,
                           const char       *text,
                           const char       *end,
                           const char       *header,
                           common_error_t   *error)
{
    int64_t row = -1;
    for (const char *line = text; line < end; line += strlen(line) + 1, row++)
    {
        char start[64];
        write_start(file, row < 0 ? 0 : (uint64_t)row, start);
        if (row < 0 ? strcmp(line, header) != 0 : strncmp(line, start, strlen(start)) != 0)
        {
            (void)common_error_set(error,
                                   "%s:%" PRId64
                                   ":1: is not of this study as it is now: remove the file, or give another folder",
                                   file->path,
                                   row + 2);
            return -1;
        }
    }
    return row < 0 ? 0 : row;
}

/// A whole file of `*size` bytes. Its complete lines, with 0 for each end of line, are the first `*length`. Null on failure.
static char *read_lines(const char *path, size_t *length, size_t *size, common_error_t *error)
{
    char *text = common_file_read(path, BYTES_MAX, error);
    if (text == NULL)
    {
        return NULL;
    }
    char *last = strrchr(text, '\n');
    *size      = strlen(text);
    *length    = last != NULL ? (size_t)(last - text) + 1 : 0;
    for (size_t i = 0; i < *length; i++)
    {
        text[i] = text[i] == '\n' ? '\0' : text[i];
    }
    return text;
}

static bool lock(sim_rows_t *file, common_error_t *error)
{
    struct flock range = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
    if (fcntl(fileno(file->stream), F_SETLK, &range) == 0)
    {
        return true;
    }
    return errno == EACCES || errno == EAGAIN
               ? common_error_set(error, "%s: another tribo-sim is writing it", file->path)
               : common_error_set(error, "%s: cannot be locked: %s", file->path, strerror(errno));
}

/// Cuts off an incomplete last row, left by a kill, and counts the others.
static bool take_up(sim_rows_t *file, const char *header, common_error_t *error)
{
    struct stat info;
    size_t      length = 0;
    size_t      size   = 0;
    char       *text   = read_lines(file->path, &length, &size, error);
    if (text == NULL)
    {
        return false;
    }
    const int64_t rows = check_lines(file, text, text + length, header, error);
    free(text);
    // Lock only now: reading closes the file once, which releases a lock.
    if (rows < 0 || !lock(file, error))
    {
        return false;
    }
    file->rows = (uint64_t)rows;
    if (fstat(fileno(file->stream), &info) == 0 && (size_t)info.st_size != size)
    {
        return common_error_set(error, "%s: another tribo-sim is writing it", file->path);
    }
    return (ftruncate(fileno(file->stream), (off_t)length) == 0 && fseek(file->stream, 0, SEEK_END) == 0) ||
           common_error_set(error, "%s: cannot be written: %s", file->path, strerror(errno));
}

static bool flush(const sim_rows_t *file, common_error_t *error)
{
    return (fflush(file->stream) == 0 && !ferror(file->stream)) ||
           common_error_set(error, "%s: cannot be written: %s", file->path, strerror(errno));
}

bool sim_rows_open(sim_rows_t *file, const char *header, uint64_t rows, common_error_t *error)
{
    struct stat info;
    const int   descriptor = open(file->path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    file->stream           = descriptor >= 0 ? fdopen(descriptor, "r+b") : NULL;
    if (file->stream == NULL)
    {
        (void)common_error_set(error, "%s: cannot be opened: %s", file->path, strerror(errno));
        if (descriptor >= 0)
        {
            (void)close(descriptor);
        }
        return false;
    }
    bool ok = fstat(descriptor, &info) == 0 && S_ISREG(info.st_mode);
    ok      = (ok || common_error_set(error, "%s: is not a regular file", file->path)) && take_up(file, header, error);
    if (ok && file->rows > sim_shard_rows(&file->shard, rows))
    {
        ok = common_error_set(error, "%s: has more rows than the study", file->path);
    }
    if (ok && ftell(file->stream) == 0)
    {
        ok = fprintf(file->stream, "%s\n", header) > 0 && flush(file, error);
    }
    if (!ok)
    {
        (void)fclose(file->stream);
        file->stream = NULL;
    }
    return ok;
}

bool sim_rows_append(sim_rows_t *file, const char *text, common_error_t *error)
{
    char start[64];
    write_start(file, file->rows++, start);
    (void)fprintf(file->stream, "%s%s\n", start, text);
    return flush(file, error);
}

bool sim_rows_close(sim_rows_t *file, common_error_t *error)
{
    const bool ok = fclose(file->stream) == 0;
    file->stream  = NULL;
    return ok || common_error_set(error, "%s: cannot be written: %s", file->path, strerror(errno));
}

char *sim_rows_read(const sim_rows_t *file, const char *header, uint64_t rows, char **first, common_error_t *error)
{
    size_t length = 0;
    size_t size   = 0;
    char  *text   = read_lines(file->path, &length, &size, error);
    if (text == NULL)
    {
        return NULL;
    }
    const uint64_t wanted = sim_shard_rows(&file->shard, rows);
    const int64_t  found  = check_lines(file, text, text + length, header, error);
    if (found >= 0 && (uint64_t)found != wanted)
    {
        (void)
            common_error_set(error, "%s: has %" PRId64 " rows of %" PRIu64 ": not finished", file->path, found, wanted);
    }
    if (found < 0 || (uint64_t)found != wanted)
    {
        free(text);
        return NULL;
    }
    *first = text + strlen(header) + 1;
    return text;
}

size_t sim_rows_split(char *row, char **field, size_t max)
{
    size_t count = 0;
    for (char *next = row; next != NULL; count++)
    {
        char *to     = next;
        char *start  = next;
        bool  quoted = *next == '"';
        next += quoted ? 1 : 0;
        while (*next != '\0' && (quoted || *next != ','))
        {
            if (quoted && *next == '"')
            {
                quoted = next[1] == '"'; // a doubled quote is a literal one
                next += quoted ? 1 : 0;
                if (!quoted)
                {
                    next++;
                    continue;
                }
            }
            *to++ = *next++;
        }
        char *after = *next == ',' ? next + 1 : NULL;
        *to         = '\0';
        if (count < max)
        {
            field[count] = start;
        }
        next = after;
    }
    return count;
}

void sim_rows_write_field(FILE *stream, const char *text)
{
    if (text[strcspn(text, ",\"\r\n")] == '\0')
    {
        (void)fputs(text, stream);
        return;
    }
    (void)fputc('"', stream);
    for (; *text != '\0'; text++)
    {
        (void)fputs(*text == '"' ? "\"" : "", stream); // doubled
        (void)fputc(*text == '\n' || *text == '\r' ? ' ' : *text, stream);
    }
    (void)fputc('"', stream);
}
