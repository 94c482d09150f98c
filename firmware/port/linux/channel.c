#include "channel.h"

#include "text_file.h"

#include <errno.h>
#include <fcntl.h>
#include <iio.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/// Reads a number of the channel that a driver may omit. A number that exists and cannot be read is an error.
static bool read_attribute(struct iio_channel     *found,
                           const char             *name,
                           double                  otherwise,
                           double                 *value,
                           const channel_config_t *config,
                           const char             *key,
                           common_error_t         *error)
{
    const int status = iio_channel_attr_read_double(found, name, value);
    *value           = status == -ENOENT ? otherwise : *value;
    const bool ok    = status == -ENOENT || (status >= 0 && isfinite(*value) && (*value != 0.0 || otherwise == 0.0));
    return ok || common_error_set(error,
                                  "%s: %s of %s of '%s' cannot be read: %s",
                                  key,
                                  name,
                                  config->channel,
                                  config->device,
                                  status < 0 ? strerror(-status) : "it is 0, or not a number");
}

static bool open_raw(channel_t *channel, const struct iio_device *device, struct iio_channel *found, bool is_output)
{
    char        path[256];
    const char *name = iio_channel_attr_get_filename(found, "raw");
    const int   length =
        snprintf(path, sizeof path, "/sys/bus/iio/devices/%s/%s", iio_device_get_id(device), name != NULL ? name : "");
    if (name == NULL || length >= (int)sizeof path)
    {
        errno = ENOENT;
        return false;
    }
    channel->file = open(path, (is_output ? O_WRONLY : O_RDONLY) | O_CLOEXEC);
    return channel->file >= 0;
}

static bool open_in(struct iio_context     *context,
                    channel_t              *channel,
                    const channel_config_t *config,
                    bool                    is_output,
                    const char             *key,
                    common_error_t         *error)
{
    const struct iio_device *device = iio_context_find_device(context, config->device);
    if (device == NULL)
    {
        return common_error_set(error, "%s.device: there is no IIO device '%s'", key, config->device);
    }
    struct iio_channel *found = iio_device_find_channel(device, config->channel, is_output);
    if (found == NULL)
    {
        return common_error_set(error,
                                "%s.channel: '%s' has no %s channel '%s'",
                                key,
                                config->device,
                                is_output ? "output" : "input",
                                config->channel);
    }
    return read_attribute(found, "scale", 1.0, &channel->scale, config, key, error) &&
           read_attribute(found, "offset", 0.0, &channel->offset, config, key, error) &&
           (open_raw(channel, device, found, is_output) ||
            common_error_set(error, "%s: %s of '%s': %s", key, config->channel, config->device, strerror(errno)));
}

bool channel_open(channel_t              *channel,
                  const channel_config_t *config,
                  bool                    is_output,
                  const char             *key,
                  common_error_t         *error)
{
    *channel                    = (channel_t){.file = -1};
    struct iio_context *context = iio_create_local_context();
    if (context == NULL)
    {
        return common_error_set(error, "%s: IIO devices cannot be listed: %s", key, strerror(errno));
    }
    const bool ok = open_in(context, channel, config, is_output, key, error);
    iio_context_destroy(context);
    float first;
    return ok && (is_output || channel_read(channel, &first) ||
                  common_error_set(error,
                                   "%s: %s of '%s' cannot be read as a number: %s",
                                   key,
                                   config->channel,
                                   config->device,
                                   strerror(errno)));
}

void channel_close(channel_t *channel)
{
    if (channel->file >= 0)
    {
        (void)close(channel->file);
        channel->file = -1;
    }
}

bool channel_read(const channel_t *channel, float *value)
{
    int64_t raw;
    if (!text_file_read(channel->file, &raw))
    {
        return false;
    }
    *value = (float)(((double)raw + channel->offset) * channel->scale);
    return true;
}

bool channel_write(const channel_t *channel, float value)
{
    return text_file_write(channel->file, llround((double)value / channel->scale - channel->offset));
}
