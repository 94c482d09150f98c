#include "loop/reference.h"

#include "support/elementary.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define TWO_PI 6.283185307179586

static const common_csv_column_t columns[] = {{.name = "t_s"}, {.name = "r_N", .max = 1e6}};

/// Refuses a device or a pipe, which might have no end.
static bool check_file(const common_scenario_t *scenario, const char *path, common_error_t *error)
{
    struct stat info;
    const char *why = (access(path, R_OK) != 0 || stat(path, &info) != 0) ? strerror(errno)
                      : S_ISREG(info.st_mode)                             ? NULL
                                                                          : "it is not a regular file";
    return why == NULL || common_error_set(error,
                                           "%s: reference.file: %s: cannot be opened: %s",
                                           common_scenario_source(scenario, "reference.file"),
                                           path,
                                           why);
}

bool common_reference_init(common_reference_t *reference, const common_scenario_t *scenario, common_error_t *error)
{
    *reference = (common_reference_t){.config = common_scenario_loop(scenario)->reference};
    if (reference->config.kind != COMMON_REFERENCE_CSV)
    {
        return true;
    }
    char *path = common_scenario_reference_path(scenario);
    if (path == NULL)
    {
        return common_error_set(error, "out of memory");
    }
    const bool ok = check_file(scenario, path, error) &&
                    common_csv_read(&reference->csv, path, columns, 2, false, error) &&
                    common_csv_check_rising(&reference->csv, "t_s", error);
    free(path);
    return ok;
}

void common_reference_free(common_reference_t *reference)
{
    common_csv_free(&reference->csv);
}

/// Returns the part of the present period that has passed, 0 to 1; 0 before the start.
static double phase(double since_s, double period_s)
{
    return (since_s > 0.0) ? fmod(since_s, period_s) / period_s : 0.0;
}

static double sine(const common_reference_config_t *config, double turns)
{
    const double middle = 0.5 * (config->low_n + config->high_n);
    return middle + 0.5 * (config->high_n - config->low_n) * common_sin(TWO_PI * turns);
}

/// Returns the turns of a chirp, the integral of its frequency.
static double chirp_turns(const common_reference_config_t *config, double since_s)
{
    const double swept = fmin(fmax(since_s, 0.0), config->sweep_s);
    const double after = fmax(since_s - config->sweep_s, 0.0);
    const double rise  = 0.5 * (config->to_hz - config->from_hz) * swept * swept / config->sweep_s;
    return config->from_hz * swept + rise + config->to_hz * after;
}

static double from_file(common_reference_t *reference, double t_s)
{
    const double *t    = reference->csv.values[0];
    const double *r    = reference->csv.values[1];
    const size_t  last = reference->csv.rows - 1;
    if (t_s <= t[0])
    {
        return r[0];
    }
    if (t_s >= t[last])
    {
        return r[last];
    }
    if (t[reference->row] > t_s)
    {
        reference->row = 0;
    }
    while (t[reference->row + 1] <= t_s)
    {
        reference->row++;
    }
    const size_t i = reference->row;
    return r[i] + (t_s - t[i]) / (t[i + 1] - t[i]) * (r[i + 1] - r[i]);
}

double common_reference_at(common_reference_t *reference, double t_s)
{
    const common_reference_config_t *config = &reference->config;

    const double since_s = t_s - config->start_s;
    const double height  = config->high_n - config->low_n;
    switch (config->kind)
    {
    case COMMON_REFERENCE_TRIANGLE:
        return config->low_n + height * (1.0 - fabs(1.0 - 2.0 * phase(since_s, config->period_s)));
    case COMMON_REFERENCE_SINE:
        return sine(config, phase(since_s, config->period_s));
    case COMMON_REFERENCE_STEP:
        return (since_s >= 0.0) ? config->high_n : config->low_n;
    case COMMON_REFERENCE_RAMP:
        return config->low_n + height * fmin(fmax(since_s / config->ramp_s, 0.0), 1.0);
    case COMMON_REFERENCE_SAWTOOTH:
        return config->low_n + height * phase(since_s, config->period_s);
    case COMMON_REFERENCE_CHIRP:
        return sine(config, chirp_turns(config, since_s));
    case COMMON_REFERENCE_CSV:
    default:
        return from_file(reference, t_s);
    }
}

double common_reference_peak(const common_reference_t *reference)
{
    const bool is_file = reference->config.kind == COMMON_REFERENCE_CSV;
    double     peak    = is_file ? 0.0 : fmax(fabs(reference->config.low_n), fabs(reference->config.high_n));
    for (size_t i = 0; is_file && i < reference->csv.rows; i++)
    {
        peak = fmax(peak, fabs(reference->csv.values[1][i]));
    }
    return peak;
}
