#include "pwm.h"

#include "text_file.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define PATH_MAX_LENGTH 192

/// Writes a number to a file of the chip or of its channel.
static bool set(const char *folder, const char *name, int64_t number)
{
    char path[PATH_MAX_LENGTH + 16];
    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    const int file = open(path, O_WRONLY | O_CLOEXEC);
    if (file < 0)
    {
        return false;
    }
    const bool ok   = text_file_write(file, number);
    const int  kept = errno;
    (void)close(file);
    errno = kept;
    return ok;
}

static int64_t duty_ns(const pwm_t *pwm, float duty)
{
    const double part = fmin(fmax((double)duty, 0.0), 1.0);
    return llround(part * (double)pwm->period_ns);
}

bool pwm_open(pwm_t *pwm, const pwm_config_t *config, float idle, const char *key, common_error_t *error)
{
    char        chip[PATH_MAX_LENGTH];
    char        channel[PATH_MAX_LENGTH];
    char        duty[PATH_MAX_LENGTH + 16];
    struct stat unused;
    *pwm = (pwm_t){.file = -1, .period_ns = (int64_t)config->period_ns};
    (void)snprintf(chip, sizeof chip, "/sys/class/pwm/%s", config->chip);
    (void)snprintf(channel, sizeof channel, "/sys/class/pwm/%s/pwm%" PRIu64, config->chip, config->channel);
    (void)snprintf(duty, sizeof duty, "%s/duty_cycle", channel);
    if (stat(chip, &unused) != 0)
    {
        return errno == ENOENT ? common_error_set(error, "%s.chip: there is no %s", key, chip)
                               : common_error_set(error, "%s.chip: %s: %s", key, chip, strerror(errno));
    }
    if (stat(channel, &unused) != 0 && (errno != ENOENT || !set(chip, "export", (int64_t)config->channel)))
    {
        return common_error_set(error,
                                "%s.channel: %s does not give channel %" PRIu64 ": %s",
                                key,
                                chip,
                                config->channel,
                                strerror(errno));
    }
    // Reset an earlier duty first, which may be longer than the new period.
    const bool period = set(channel, "period", pwm->period_ns) ||
                        (set(channel, "duty_cycle", 0) && set(channel, "period", pwm->period_ns));
    const bool ok = period && set(channel, "duty_cycle", duty_ns(pwm, idle)) && set(channel, "enable", 1);
    pwm->file     = ok ? open(duty, O_WRONLY | O_CLOEXEC) : -1;
    return pwm->file >= 0 || common_error_set(error, "%s: %s cannot be set up: %s", key, channel, strerror(errno));
}

void pwm_close(pwm_t *pwm)
{
    if (pwm->file >= 0)
    {
        (void)close(pwm->file);
        pwm->file = -1;
    }
}

bool pwm_write(const pwm_t *pwm, float duty)
{
    return text_file_write(pwm->file, duty_ns(pwm, duty));
}
