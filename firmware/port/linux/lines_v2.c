// Lines through libgpiod 2, as in Debian 13.

#include "lines.h"

#include <dirent.h>
#include <errno.h>
#include <gpiod.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EVENTS 16u ///< events read at a time

struct lines
{
    struct gpiod_line_request      *request[LINE_COUNT]; ///< null: not used
    unsigned                        offset[LINE_COUNT];
    struct gpiod_edge_event_buffer *events;
};

static struct gpiod_chip *open_number(int number)
{
    char path[32];
    (void)snprintf(path, sizeof path, "/dev/gpiochip%d", number);
    return gpiod_is_gpiochip_device(path) ? gpiod_chip_open(path) : NULL;
}

static bool has_label(struct gpiod_chip *chip, const char *label)
{
    struct gpiod_chip_info *info = gpiod_chip_get_info(chip);
    const bool              same = info != NULL && (strcmp(gpiod_chip_info_get_label(info), label) == 0 ||
                                       strcmp(gpiod_chip_info_get_name(info), label) == 0);
    gpiod_chip_info_free(info);
    return same;
}

/// Numbers of chips may have gaps, because chips come and go.
#define CHIPS_MAX 1024

/// Finds the chip that has the line, and the line's place in it.
static struct gpiod_chip *find(const line_config_t *config, unsigned *offset)
{
    *offset = (unsigned)config->offset;
    if (config->name[0] == '\0' && config->chip[0] == '/')
    {
        return gpiod_chip_open(config->chip);
    }
    int why = ENOENT;
    for (int number = 0; number < CHIPS_MAX; number++)
    {
        errno                   = ENOENT;
        struct gpiod_chip *chip = open_number(number);
        if (chip == NULL)
        {
            why = errno == EACCES || errno == EPERM ? errno : why; // this chip may have the line
            continue;
        }
        const int place =
            config->name[0] != '\0' ? gpiod_chip_get_line_offset_from_name(chip, config->name)
            : has_label(chip, config->chip) || (config->chip[0] != '\0' && strtol(config->chip, NULL, 10) == number &&
                                                strspn(config->chip, "0123456789") == strlen(config->chip))
                ? (int)config->offset
                : -1;
        if (place >= 0)
        {
            *offset = (unsigned)place;
            return chip;
        }
        gpiod_chip_close(chip);
    }
    errno = why;
    return NULL;
}

static struct gpiod_line_settings *settings_of(const line_config_t *config, bool is_output)
{
    static const enum gpiod_line_bias bias[]   = {[LINE_BIAS_AS_IS]     = GPIOD_LINE_BIAS_AS_IS,
                                                  [LINE_BIAS_DISABLED]  = GPIOD_LINE_BIAS_DISABLED,
                                                  [LINE_BIAS_PULL_UP]   = GPIOD_LINE_BIAS_PULL_UP,
                                                  [LINE_BIAS_PULL_DOWN] = GPIOD_LINE_BIAS_PULL_DOWN};
    struct gpiod_line_settings       *settings = gpiod_line_settings_new();
    if (settings != NULL)
    {
        (void)gpiod_line_settings_set_direction(settings,
                                                is_output ? GPIOD_LINE_DIRECTION_OUTPUT : GPIOD_LINE_DIRECTION_INPUT);
        (void)gpiod_line_settings_set_edge_detection(settings, is_output ? GPIOD_LINE_EDGE_NONE : GPIOD_LINE_EDGE_BOTH);
        (void)gpiod_line_settings_set_bias(settings, bias[config->bias]);
        gpiod_line_settings_set_active_low(settings, config->active_low != 0);
        (void)gpiod_line_settings_set_output_value(settings, GPIOD_LINE_VALUE_INACTIVE);
    }
    return settings;
}

static struct gpiod_line_request *request(struct gpiod_chip   *chip,
                                          unsigned             offset,
                                          bool                 is_output,
                                          const line_config_t *config,
                                          const char          *consumer)
{
    struct gpiod_line_settings  *settings = settings_of(config, is_output);
    struct gpiod_line_config    *lines    = gpiod_line_config_new();
    struct gpiod_request_config *how      = gpiod_request_config_new();
    struct gpiod_line_request   *made     = NULL;
    if (settings != NULL && lines != NULL && how != NULL &&
        gpiod_line_config_add_line_settings(lines, &offset, 1, settings) == 0)
    {
        gpiod_request_config_set_consumer(how, consumer);
        made = gpiod_chip_request_lines(chip, how, lines);
    }
    const int kept = errno;
    gpiod_request_config_free(how);
    gpiod_line_config_free(lines);
    gpiod_line_settings_free(settings);
    errno = kept;
    return made;
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
    struct gpiod_chip *chip = find(config, &lines->offset[number]);
    if (chip == NULL)
    {
        return common_error_set(error,
                                "%s: there is no such line, or it cannot be seen: %s",
                                text,
                                strerror(errno != 0 ? errno : ENOENT));
    }
    lines->request[number] = request(chip, lines->offset[number], number <= LINE_PROBE, config, consumer);
    const int kept         = errno;
    gpiod_chip_close(chip);
    return lines->request[number] != NULL ||
           common_error_set(error, "%s: cannot be requested: %s", text, strerror(kept));
}

lines_t *lines_open(const line_config_t config[LINE_COUNT], const char *consumer, common_error_t *error)
{
    lines_t *lines = calloc(1, sizeof *lines);
    if (lines == NULL)
    {
        (void)common_error_set(error, "out of memory");
        return NULL;
    }
    lines->events = gpiod_edge_event_buffer_new(EVENTS);
    bool ok       = lines->events != NULL || common_error_set(error, "out of memory");
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
    if (lines == NULL)
    {
        return;
    }
    for (int i = 0; i < LINE_COUNT; i++)
    {
        if (lines->request[i] != NULL)
        {
            gpiod_line_request_release(lines->request[i]);
        }
    }
    gpiod_edge_event_buffer_free(lines->events);
    free(lines);
}

bool lines_set(lines_t *lines, line_t output, bool high)
{
    return lines->request[output] == NULL ||
           gpiod_line_request_set_value(lines->request[output],
                                        lines->offset[output],
                                        high ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE) == 0;
}

bool lines_read_back(lines_t *lines, line_t output, bool *high)
{
    const enum gpiod_line_value level =
        lines->request[output] != NULL ? gpiod_line_request_get_value(lines->request[output], lines->offset[output])
                                       : GPIOD_LINE_VALUE_ERROR;
    *high = level == GPIOD_LINE_VALUE_ACTIVE;
    return level != GPIOD_LINE_VALUE_ERROR;
}

bool lines_seen(lines_t *lines, line_t input, bool *high, bool *low)
{
    struct gpiod_line_request *line = lines->request[input];
    *high = *low = false;
    if (line == NULL)
    {
        return true;
    }
    int waiting;
    while ((waiting = gpiod_line_request_wait_edge_events(line, 0)) > 0)
    {
        if (gpiod_line_request_read_edge_events(line, lines->events, EVENTS) <= 0)
        {
            return false;
        }
        *high = *low = true; // the line had one level before the edge and the other after it
    }
    const enum gpiod_line_value level = gpiod_line_request_get_value(line, lines->offset[input]);
    *high                             = *high || level == GPIOD_LINE_VALUE_ACTIVE;
    *low                              = *low || level == GPIOD_LINE_VALUE_INACTIVE;
    return waiting == 0 && level != GPIOD_LINE_VALUE_ERROR;
}
