#include "core.h"

#include "joint.h"

#include "loop/effective.h"
#include "scenario/columns.h"
#include "scenario/config.h"
#include "scenario/runner.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static common_error_t     error;
static common_scenario_t *scenario;
static sim_summary_t      summary;
static joint_result_t     joint;
static bool               is_joint; // false: the last run was a scenario
static double            *columns[SIM_COLUMNS_MAX];
static unsigned           column_count;
static size_t             tick_count, rows;
static char              *scenario_text;

char *playground_room(size_t size)
{
    return malloc(size);
}

static void forget(void)
{
    common_scenario_destroy(scenario);
    scenario = NULL;
    free(columns[0]);
    free(scenario_text);
    scenario_text = NULL;
    memset(columns, 0, sizeof columns);
    error = (common_error_t){""};
    rows  = 0;
}

static bool record(void *context, const sim_row_t *row, double part_done, common_error_t *problem)
{
    (void)context, (void)part_done, (void)problem;
    double values[SIM_COLUMNS_MAX];
    (void)sim_column_values(row, values);
    for (unsigned i = 0; i < column_count; i++)
    {
        columns[i][rows] = values[i];
    }
    rows++;
    return true;
}

static bool make_columns(size_t ticks, unsigned count)
{
    tick_count   = ticks;
    column_count = count;
    columns[0]   = tick_count < SIZE_MAX / sizeof(double) / SIM_COLUMNS_MAX
                       ? malloc(tick_count * column_count * sizeof(double))
                       : NULL;
    for (unsigned i = 1; columns[0] != NULL && i < column_count; i++)
    {
        columns[i] = columns[0] + i * tick_count;
    }
    return columns[0] != NULL || common_error_set(&error, "duration_s: the run is too long for this page's memory");
}

static bool make_columns_of_scenario(void)
{
    const sim_config_t *config = sim_scenario_config(scenario);
    return make_columns((size_t)(config->duration_s / config->loop.sample_time_s + 0.5),
                        sim_column_count(sim_run_learns(config)));
}

bool playground_play(char *text, bool q31)
{
    forget();
    is_joint                        = false;
    scenario                        = sim_scenario_create();
    const sim_run_options_t options = {.q31 = q31};
    const bool              ok = scenario != NULL && common_scenario_load_text(scenario, text, "scenario", &error) &&
                    sim_scenario_check(scenario, &error) && make_columns_of_scenario() &&
                    sim_run(scenario, &options, record, NULL, &summary, &error);
    free(text);
    return ok || common_error_set(&error, "out of memory"); // keeps an earlier error
}

bool playground_play_joint(double *settings)
{
    joint_settings_t own;
    memcpy(&own, settings, sizeof own);
    free(settings);
    forget();
    is_joint = true;
    if (!make_columns(JOINT_TICKS, JOINT_COLUMNS) || !joint_play(&own, columns, &joint, &error))
    {
        return false;
    }
    rows = JOINT_TICKS;
    return true;
}

const char *playground_complaint(void)
{
    return error.text;
}

size_t playground_row_count(void)
{
    return rows;
}

unsigned playground_column_count(void)
{
    return column_count;
}

const char *playground_column_name(unsigned column)
{
    return is_joint ? joint_column_names[column] : sim_columns[column].name;
}

const double *playground_column(unsigned column)
{
    return columns[column];
}

double playground_rms_error(void)
{
    return is_joint ? joint.rms_error : summary.result.rms_error_n;
}

double playground_max_error(void)
{
    return is_joint ? joint.max_error : summary.result.max_error_n;
}

const char *playground_guard(void)
{
    if (is_joint)
    {
        return joint.cause;
    }
    return summary.result.guard != NULL ? summary.result.guard : "";
}

const char *playground_scenario_text(void)
{
    size_t     size   = 0;
    FILE      *stream = open_memstream(&scenario_text, &size);
    const bool ok     = stream != NULL && common_scenario_write(stream, scenario, &error);
    return stream != NULL && fclose(stream) == 0 && ok ? scenario_text : "";
}

uint64_t playground_digest(void)
{
    uint64_t digest = 0xcbf29ce484222325u;
    for (unsigned i = 0; i < column_count; i++)
    {
        for (size_t k = 0; k < rows; k++)
        {
            uint64_t bits;
            memcpy(&bits, &columns[i][k], sizeof bits);
            digest = (digest ^ bits) * 0x100000001b3u;
        }
    }
    return digest;
}
