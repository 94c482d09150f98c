#include "app/config.h"

#include <stddef.h>
#include <string.h>

const drive_config_field_t drive_config_fields[DRIVE_CONFIG_COUNT] = {
#define FIELD(type, name, unit, low, high, off, normal, change, text)                                                  \
    {(float)(low), (float)(high), (type)0.5 != 0, (off) != 0, DRIVE_##change == DRIVE_WIRED},
    DRIVE_CONFIG_FIELDS(FIELD)
#undef FIELD
};

_Static_assert(sizeof(drive_config_t) == DRIVE_CONFIG_COUNT * sizeof(uint32_t), "words without gaps");

const char *drive_config_name(unsigned field)
{
    static const char *const names[DRIVE_CONFIG_COUNT] = {
#define NAME(type, name, unit, low, high, off, normal, change, text) #name,
        DRIVE_CONFIG_FIELDS(NAME)
#undef NAME
    };
    return field < DRIVE_CONFIG_COUNT ? names[field] : "";
}

float drive_config_value(const drive_config_t *config, unsigned field)
{
    uint32_t word;
    float    number;
    memcpy(&word, (const unsigned char *)config + field * sizeof word, sizeof word);
    memcpy(&number, &word, sizeof number);
    return drive_config_fields[field].is_float ? number : (float)word;
}

drive_config_t drive_config_default(void)
{
#define DEFAULT(type, name, unit, low, high, off, normal, change, text) .name = (normal),
    return (drive_config_t){DRIVE_CONFIG_FIELDS(DEFAULT)};
#undef DEFAULT
}

static bool is_within(const drive_config_error_t *field)
{
    return (field->value >= field->low && field->value <= field->high) || (field->off && field->value == 0.0f);
}

/// Checks fields against each other. Returns false and fills `error` for the first that does not fit another one.
static bool check_each_other(const drive_config_t *config, drive_config_error_t *error)
{
    const float                period_us = (float)config->period_us;
    const drive_config_error_t fields[]  = {
        {DRIVE_CONFIG_late_us, (float)config->late_us, 0.0f, period_us - 1.0f, false},
        {DRIVE_CONFIG_budget_us, (float)config->budget_us, 1.0f, period_us, false},
        {DRIVE_CONFIG_debounce_n, (float)config->debounce_n, 1.0f, (float)config->debounce_m, false}};
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
    for (unsigned i = 0; i < DRIVE_CONFIG_COUNT; i++)
    {
        const drive_config_field_t *field = &drive_config_fields[i];
        const float                 value = drive_config_value(config, i);
        *error                            = (drive_config_error_t){i, value, field->low, field->high, field->off};
        if (!is_within(error))
        {
            return false;
        }
    }
    return check_each_other(config, error);
}
