#include "counter.h"

#include "text_file.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <unistd.h>

static bool read_count(const counter_t *counter, uint32_t *count)
{
    int64_t    number = 0;
    const bool ok     = text_file_read(counter->file, &number);
    *count            = (uint32_t)number * counter->step;
    return ok;
}

bool counter_open(counter_t *counter, const counter_config_t *config, const char *key, common_error_t *error)
{
    *counter = (counter_t){.file = open(config->file, O_RDONLY | O_CLOEXEC), .step = 1u << (32u - config->bits)};
    if (counter->file < 0)
    {
        return common_error_set(error, "%s.file: %s: %s", key, config->file, strerror(errno));
    }
    return read_count(counter, &counter->count) || common_error_set(error,
                                                                    "%s.file: %s cannot be read as a whole number: %s",
                                                                    key,
                                                                    config->file,
                                                                    strerror(errno));
}

void counter_close(counter_t *counter)
{
    if (counter->file >= 0)
    {
        (void)close(counter->file);
        counter->file = -1;
    }
}

int32_t counter_read(counter_t *counter)
{
    uint32_t   count;
    const bool ok    = read_count(counter, &count);
    int32_t    moved = INT32_MAX;
    if (ok)
    {
        moved          = (int32_t)((int64_t)(int32_t)(count - counter->count) / counter->step);
        counter->count = count;
    }
    counter->units = (int32_t)((uint32_t)counter->units + (uint32_t)moved);
    return counter->units;
}
