/// Writes to a PWM output of sysfs. Its number is the duty, 0 to 1.

#ifndef LINUX_PWM_H
#define LINUX_PWM_H

#include "support/error.h"

#include <stdbool.h>
#include <stdint.h>

#define PWM_NAME_MAX 63u

typedef struct
{
    char     chip[PWM_NAME_MAX + 1]; ///< name of the chip in /sys/class/pwm, e.g. pwmchip0
    uint64_t channel;
    uint64_t period_ns;
} pwm_config_t;

typedef struct
{
    int     file; ///< file duty_cycle
    int64_t period_ns;
} pwm_t;

/// Exports the channel if necessary, sets its period and the duty `idle`, and turns it on. Returns false with `key`, the
/// file and the cause in `error`.
bool pwm_open(pwm_t *pwm, const pwm_config_t *config, float idle, const char *key, common_error_t *error);
void pwm_close(pwm_t *pwm);

/// Writes the duty to the nearest nanosecond. Returns false if the chip refuses it.
bool pwm_write(const pwm_t *pwm, float duty);

#endif
