#include "app/config.h"

drive_config_t drive_config_default(void)
{
#define DEFAULT(type, name, unit, low, high, off, normal, text) .name = (normal),
    return (drive_config_t){DRIVE_CONFIG_FIELDS(DEFAULT)};
#undef DEFAULT
}

static bool is_within(const drive_config_error_t *field)
{
    return (field->value >= field->low && field->value <= field->high) || (field->off && field->value == 0.0f);
}

/// Between fields: false with `error` for the first that does not fit another.
static bool check_each_other(const drive_config_t *config, drive_config_error_t *error)
{
    const float                period_us = (float)config->period_us;
    const drive_config_error_t fields[]  = {{"late_us", (float)config->late_us, 0.0f, period_us - 1.0f, false},
                                            {"budget_us", (float)config->budget_us, 1.0f, period_us, false}};
    for (unsigned i = 0; i < sizeof fields / sizeof fields[0]; i++)
    {
        if (!is_within(&fields[i]))
        {
            *error = fields[i];
            return false;
        }
    }
    return true;
}

bool drive_config_check(const drive_config_t *config, drive_config_error_t *error)
{
#define CHECK(type, name, unit, low, high, off, normal, text)                                                          \
    *error = (drive_config_error_t){#name, (float)config->name, (float)(low), (float)(high), (off) != 0};              \
    if (!is_within(error))                                                                                             \
    {                                                                                                                  \
        return false;                                                                                                  \
    }
    DRIVE_CONFIG_FIELDS(CHECK)
#undef CHECK
    return check_each_other(config, error);
}
