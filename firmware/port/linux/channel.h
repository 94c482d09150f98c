/// A channel of an IIO device, found by libiio: one number read or written a tick.
///
/// A number is (raw + offset) * scale, in the unit of the kernel's IIO interface, e.g. mV for a
/// voltage. Its file is kept open, so that a tick neither allocates nor opens anything.

#ifndef LINUX_CHANNEL_H
#define LINUX_CHANNEL_H

#include "support/error.h"

#include <stdbool.h>

#define CHANNEL_NAME_MAX 63u

typedef struct
{
    char device[CHANNEL_NAME_MAX + 1];  ///< name, label or id of the device (iio:device0)
    char channel[CHANNEL_NAME_MAX + 1]; ///< id of the channel, e.g. voltage0
} channel_config_t;

typedef struct
{
    int    file;
    double scale, offset;
} channel_t;

/// Opens a channel for writing, or an input for reading, and reads it once, because a converter's first number may take longer.
/// Returns false with `key`, the device and the cause in `error`.
bool channel_open(channel_t              *channel,
                  const channel_config_t *config,
                  bool                    is_output,
                  const char             *key,
                  common_error_t         *error);
void channel_close(channel_t *channel);

/// Reads a number. Returns false if there is none, e.g. because the device is gone. A conversion takes as long as the device
/// takes.
bool channel_read(const channel_t *channel, float *value);
/// Writes the nearest code. Returns false if the device refuses it.
bool channel_write(const channel_t *channel, float value);

#endif
