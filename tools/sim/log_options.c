#include "sim/log_options.h"

#include "sim/commands.h"
#include "support/file.h"
#include "support/number.h"

#include <stdio.h>

static int seconds(double *value, const char *option, const char *text)
{
    return common_number_parse(text, value) == NULL && *value > 0.0 && *value <= 86400.0
               ? 0
               : sim_usage("--%s %s: a number over 0 to 86400 s is expected", option, text);
}

static int refusal(const common_error_t *error)
{
    return sim_usage("%s", error->text);
}

int sim_log_take(sim_log_arguments_t *arguments, int key, const char *value)
{
    sim_log_options_t *options = &arguments->options;
    common_error_t     error   = {""};
    switch (key)
    {
    case SIM_OPTION_ARGUMENT:
        if (arguments->count == SIM_LOG_FILES_MAX)
        {
            return sim_usage("more than %u logs", SIM_LOG_FILES_MAX);
        }
        arguments->paths[arguments->count++] = value;
        return 0;
    case SIM_LOG_OPTION_COLUMN:
        return sim_log_set_column(options, value, &error) ? 0 : refusal(&error);
    case SIM_LOG_OPTION_UNIT:
        return sim_log_set_unit(options, value, &error) ? 0 : refusal(&error);
    case SIM_LOG_OPTION_SCALE:
        return sim_log_set_scale(options, value, &error) ? 0 : refusal(&error);
    case SIM_LOG_OPTION_BIAS:
        return sim_log_set_bias(options, value, &error) ? 0 : refusal(&error);
    case SIM_LOG_OPTION_RESAMPLE:
        options->resample = true;
        return value == NULL ? 0 : seconds(&options->rate_s, "resample", value);
    case SIM_LOG_OPTION_GAP:
        return seconds(&options->gap_s, "gap", value);
    default:
        return -1;
    }
}

int sim_log_check(const sim_log_arguments_t *arguments, const char *command, const char *option, const char *result)
{
    if (arguments->options.gap_s > 0.0 && !arguments->options.resample)
    {
        return sim_usage("%s: --gap needs --resample", command);
    }
    for (size_t i = 0; result != NULL && i < arguments->count; i++)
    {
        if (common_file_is_same(result, arguments->paths[i]))
        {
            return sim_usage("%s: --%s %s is the same file as the log %s",
                             command,
                             option,
                             result,
                             arguments->paths[i]);
        }
    }
    return 0;
}

void sim_log_report(const sim_log_t *log, const char *path)
{
    const sim_log_report_t *report = &log->report;
    if (report->resampled)
    {
        (void)fprintf(stderr,
                      "%s: resampled %zu rows to %zu at %.6g s: %zu intervals off by more than 1 %%, %zu gaps (the "
                      "longest %.3g s), "
                      "%zu stamps twice, %zu out of order, split at %zu gaps\n",
                      path,
                      report->rows_read,
                      log->rows,
                      log->sample_time_s,
                      report->jittery,
                      report->gaps,
                      report->largest_s,
                      report->repeated,
                      report->moved_rows,
                      report->splits);
    }
    if (report->left_out > 0)
    {
        (void)fprintf(stderr,
                      "%s: %zu of %zu rows are broken, left out and bridged; the first: %s\n",
                      path,
                      report->left_out,
                      report->rows_read + report->left_out,
                      report->left_out_first);
    }
    if (report->last_place_s > 0.0)
    {
        (void)fprintf(stderr,
                      "%s: stamps in steps of %.3g s are those of an even clock of %.6g s\n",
                      path,
                      report->last_place_s,
                      log->sample_time_s);
    }
    if (report->moved > 0)
    {
        (void)fprintf(stderr, "%s: the stamps of %zu files are moved to follow the file before\n", path, report->moved);
    }
}
