/// The options that all commands that read logs share.

#ifndef SIM_CLI_LOG_OPTIONS_H
#define SIM_CLI_LOG_OPTIONS_H

#include "log/log.h"
#include "sim/options.h"

enum
{
    SIM_LOG_OPTION_COLUMN = 0x4000,
    SIM_LOG_OPTION_UNIT,
    SIM_LOG_OPTION_SCALE,
    SIM_LOG_OPTION_BIAS,
    SIM_LOG_OPTION_RESAMPLE,
    SIM_LOG_OPTION_GAP
};

// clang-format off: one row an option
#define SIM_LOG_OPTIONS \
    {.name = "column", .key = SIM_LOG_OPTION_COLUMN, .arg = "ROLE=NAME", .doc = "the column of t, u, F, x (position), v (speed) or r (reference), e.g. u=torque_cmd, or u=#2 for the second column"}, \
    {.name = "unit", .key = SIM_LOG_OPTION_UNIT, .arg = "ROLE=UNIT", .doc = "e.g. t=ms, F=mN; u='N m', A or V with a scale"}, \
    {.name = "scale", .key = SIM_LOG_OPTION_SCALE, .arg = "ROLE=X", .doc = "multiplies the column; `-` changes its sign; for a torque in N per N m (1/lever)"}, \
    {.name = "bias", .key = SIM_LOG_OPTION_BIAS, .arg = "ROLE=X", .doc = "adds this, in s, N or deg, after the scale"}, \
    {.name = "resample", .key = SIM_LOG_OPTION_RESAMPLE, .arg = "S", .flags = OPTION_ARG_OPTIONAL, .doc = "resamples jittering stamps and small gaps, linear between rows, to this interval or by default the median one"}, \
    {.name = "gap", .key = SIM_LOG_OPTION_GAP, .arg = "S", .doc = "with --resample: a longer gap splits the log; ten intervals if left out"}
// clang-format on

/// A command's logs.
typedef struct
{
    sim_log_options_t options;
    const char       *paths[SIM_LOG_FILES_MAX];
    size_t            count;
} sim_log_arguments_t;

/// Takes one of SIM_LOG_OPTIONS, or a path for SIM_OPTION_ARGUMENT. Returns 0 or the exit status; negative for other options.
int sim_log_take(sim_log_arguments_t *arguments, int key, const char *value);

/// Refuses --gap without --resample, and a result that would take the place of a log. Returns 0 or the exit status.
int sim_log_check(const sim_log_arguments_t *arguments, const char *command, const char *option, const char *result);

/// Reports repairs of the log on stderr.
void sim_log_report(const sim_log_t *log, const char *path);

#endif
