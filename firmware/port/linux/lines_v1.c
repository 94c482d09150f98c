// Lines through libgpiod 1, as in Debian 12.

#include "lines.h"

#include <errno.h>
#include <fcntl.h>
#include <gpiod.h>
#include <stdlib.h>
#include <string.h>

struct lines
{
    struct gpiod_line *line[LINE_COUNT]; ///< null: not used
};

static int flags_of(const line_config_t *config)
{
    static const int bias[] = {[LINE_BIAS_AS_IS]     = 0,
                               [LINE_BIAS_DISABLED]  = GPIOD_LINE_REQUEST_FLAG_BIAS_DISABLE,
                               [LINE_BIAS_PULL_UP]   = GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP,
                               [LINE_BIAS_PULL_DOWN] = GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN};
    return bias[config->bias] | (config->active_low != 0 ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0);
}

static struct gpiod_line *find(const line_config_t *config)
{
    if (config->name[0] != '\0')
    {
        return gpiod_line_find(config->name);
    }
    struct gpiod_chip *chip = gpiod_chip_open_lookup(config->chip);
    struct gpiod_line *line = chip != NULL ? gpiod_chip_get_line(chip, (unsigned)config->offset) : NULL;
    if (chip != NULL && line == NULL)
    {
        gpiod_chip_close(chip);
    }
    return line;
}

static bool request(struct gpiod_line *line, bool is_output, const line_config_t *config, const char *consumer)
{
    const struct gpiod_line_request_config how = {.consumer     = consumer,
                                                  .request_type = is_output ? GPIOD_LINE_REQUEST_DIRECTION_OUTPUT
                                                                            : GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES,
                                                  .flags        = flags_of(config)};
    if (gpiod_line_request(line, &how, 0) != 0)
    {
        return false;
    }
    if (is_output)
    {
        return true;
    }
    const int fd = gpiod_line_event_get_fd(line);
    return fd >= 0 && fcntl(fd, F_SETFL, O_NONBLOCK) == 0;
}

static bool open_line(lines_t             *lines,
                      line_t               number,
                      const line_config_t *config,
                      const char          *consumer,
                      common_error_t      *error)
{
    char text[3 * LINES_NAME_MAX];
    line_describe(number, config, text, sizeof text);
    errno                   = 0;
    struct gpiod_line *line = find(config);
    if (line == NULL)
    {
        return common_error_set(error,
                                "%s: there is no such line, or it cannot be seen: %s",
                                text,
                                strerror(errno != 0 ? errno : ENOENT));
    }
    lines->line[number] = line;
    return request(line, number <= LINE_PROBE, config, consumer) ||
           common_error_set(error, "%s: cannot be requested: %s", text, strerror(errno));
}

lines_t *lines_open(const line_config_t config[LINE_COUNT], const char *consumer, common_error_t *error)
{
    lines_t *lines = calloc(1, sizeof *lines);
    if (lines == NULL)
    {
        (void)common_error_set(error, "out of memory");
        return NULL;
    }
    bool ok = true;
    for (int i = 0; ok && i < LINE_COUNT; i++)
    {
        ok = !line_is_used(&config[i]) || open_line(lines, (line_t)i, &config[i], consumer, error);
    }
    if (!ok)
    {
        lines_close(lines);
        return NULL;
    }
    return lines;
}

void lines_close(lines_t *lines)
{
    for (int i = 0; lines != NULL && i < LINE_COUNT; i++)
    {
        if (lines->line[i] != NULL)
        {
            gpiod_chip_close(gpiod_line_get_chip(lines->line[i])); // releases the line; each has a chip of its own
        }
    }
    free(lines);
}

bool lines_set(lines_t *lines, line_t output, bool high)
{
    return lines->line[output] == NULL || gpiod_line_set_value(lines->line[output], high) == 0;
}

bool lines_read_back(lines_t *lines, line_t output, bool *high)
{
    const int level = lines->line[output] != NULL ? gpiod_line_get_value(lines->line[output]) : -1;
    *high           = level == 1;
    return level >= 0;
}

bool lines_seen(lines_t *lines, line_t input, bool *high, bool *low)
{
    struct gpiod_line *line = lines->line[input];
    *high = *low = false;
    if (line == NULL)
    {
        return true;
    }
    struct gpiod_line_event event;
    while (gpiod_line_event_read(line, &event) == 0)
    {
        *high = *low = true; // the line had one level before the edge and the other after it
    }
    if (errno != EAGAIN)
    {
        return false;
    }
    const int level = gpiod_line_get_value(line);
    *high           = *high || level == 1;
    *low            = *low || level == 0;
    return level >= 0;
}
