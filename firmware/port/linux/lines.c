#include "lines.h"

#include <inttypes.h>
#include <stdio.h>

const char *const line_names[LINE_COUNT] = {[LINE_ENABLE]         = "enable",
                                            [LINE_HEARTBEAT]      = "heartbeat",
                                            [LINE_PROBE]          = "probe",
                                            [LINE_EMERGENCY_STOP] = "emergency_stop",
                                            [LINE_POWER_FAULT]    = "power_fault",
                                            [LINE_READY]          = "ready"};

bool line_is_used(const line_config_t *config)
{
    return config->name[0] != '\0' || config->chip[0] != '\0';
}

void line_describe(line_t line, const line_config_t *config, char *text, size_t size)
{
    if (config->name[0] != '\0')
    {
        (void)snprintf(text, size, "lines.%s ('%s')", line_names[line], config->name);
        return;
    }
    (void)snprintf(text, size, "lines.%s (%s line %" PRIu64 ")", line_names[line], config->chip, config->offset);
}
