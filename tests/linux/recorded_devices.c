// Devices and lines of tribo-drive that write down what they are told, in place of libgpiod, libiio and sysfs: the rest of the program
// is the real one. The record is the file TRIBO_RECORD, shared by both processes:
//
//     uint64    level of enable
//     uint64    times that enable went off
//     int64     when it last did, in ns of CLOCK_MONOTONIC
//     uint64    ticks
//     int64     the output, in 1e-6 units
//
// F follows the output as a first-order lag. What reads an attribute of a channel gets TRIBO_ATTRIBUTE_ERROR, if there is one.

#include "lines.h"
#include "realtime.h"
#include "text_file.h"

#include <errno.h>
#include <fcntl.h>
#include <iio.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#define MICRO 1e-6
#define LAG   0.1 ///< of the way to the output, a reading

struct lines
{
    atomic_uint_fast64_t enable, times_off;
    atomic_int_fast64_t  off_ns;
    atomic_uint_fast64_t ticks;
    atomic_int_fast64_t  output;
};

static lines_t *record;

lines_t *lines_open(const line_config_t config[LINE_COUNT], const char *consumer, common_error_t *error)
{
    const char *path = getenv("TRIBO_RECORD");
    const int   file = path != NULL ? open(path, O_RDWR | O_CLOEXEC) : -1;
    (void)config;
    (void)consumer;
    record = file >= 0 ? mmap(NULL, sizeof *record, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0) : MAP_FAILED;
    if (record == MAP_FAILED)
    {
        (void)common_error_set(error, "TRIBO_RECORD: %s", strerror(errno));
        return NULL;
    }
    return record;
}

void lines_close(lines_t *lines)
{
    (void)lines;
}

bool lines_set(lines_t *lines, line_t output, bool high)
{
    if (output == LINE_ENABLE && atomic_exchange(&lines->enable, high) != 0u && !high)
    {
        atomic_store(&lines->off_ns, realtime_now_ns());
        (void)atomic_fetch_add(&lines->times_off, 1u);
    }
    (void)atomic_fetch_add(&lines->ticks, output == LINE_PROBE && high);
    return true;
}

bool lines_read_back(lines_t *lines, line_t output, bool *high)
{
    *high = output == LINE_ENABLE && atomic_load(&lines->enable) != 0u;
    return output == LINE_ENABLE;
}

bool lines_seen(lines_t *lines, line_t input, bool *high, bool *low)
{
    (void)lines;
    (void)input;
    *high = false;
    *low  = true;
    return true;
}

// --- libiio ----------------------------------------------------------------------------------------------------------

static char a_thing; ///< whose address stands for a context, a device, a channel

struct iio_context *iio_create_local_context(void)
{
    return (struct iio_context *)&a_thing;
}

void iio_context_destroy(struct iio_context *context)
{
    (void)context;
}

struct iio_device *iio_context_find_device(const struct iio_context *context, const char *name)
{
    (void)context;
    (void)name;
    return (struct iio_device *)&a_thing;
}

struct iio_channel *iio_device_find_channel(const struct iio_device *device, const char *name, bool output)
{
    (void)device;
    (void)name;
    (void)output;
    return (struct iio_channel *)&a_thing;
}

const char *iio_device_get_id(const struct iio_device *device)
{
    (void)device;
    return "iio:device0";
}

const char *iio_channel_attr_get_filename(const struct iio_channel *channel, const char *attribute)
{
    (void)channel;
    (void)attribute;
    return "raw";
}

int iio_channel_attr_read_double(const struct iio_channel *channel, const char *attribute, double *value)
{
    const char *asked = getenv("TRIBO_ATTRIBUTE"); // "NAME ERRNO"
    (void)channel;
    if (asked != NULL && strncmp(asked, attribute, strlen(attribute)) == 0)
    {
        return -(int)strtol(asked + strlen(attribute), NULL, 10);
    }
    *value = MICRO;
    return strcmp(attribute, "scale") == 0 ? 0 : -ENOENT;
}

// --- sysfs -----------------------------------------------------------------------------------------------------------

// NOLINTBEGIN(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp): names of ld --wrap
int  __real_open(const char *path, int flags, ...);
int  __wrap_open(const char *path, int flags, ...);
int  __wrap___open_2(const char *path, int flags);
bool __wrap_text_file_read(int file, int64_t *number);
bool __wrap_text_file_write(int file, int64_t number);

int __wrap_open(const char *path, int flags, ...)
{
    va_list arguments;
    va_start(arguments, flags);
    const int mode = (flags & O_CREAT) != 0 ? va_arg(arguments, int) : 0;
    va_end(arguments);
    return __real_open(strncmp(path, "/sys/bus/iio/", 13) == 0 ? "/dev/null" : path, flags, mode);
}

/// What _FORTIFY_SOURCE makes of it.
int __wrap___open_2(const char *path, int flags)
{
    return __wrap_open(path, flags);
}

bool __wrap_text_file_read(int file, int64_t *number)
{
    static double force;
    (void)file;
    force += LAG * ((double)atomic_load(&record->output) - force);
    *number = (int64_t)force;
    return true;
}

bool __wrap_text_file_write(int file, int64_t number)
{
    (void)file;
    atomic_store(&record->output, number);
    return true;
}
// NOLINTEND(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)
