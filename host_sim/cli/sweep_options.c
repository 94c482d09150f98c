#include "cli/sweep_options.h"

#include "cli/scenario_choice.h"
#include "support/output_file.h"
#include "support/text.h"
#include "sweep/report.h"

#include <inttypes.h>
#include <stdlib.h>

sim_study_t *sim_sweep_open(const char *name, common_error_t *error)
{
    char        *path  = sim_study_path(name);
    sim_study_t *study = path != NULL ? sim_study_open(path, sim_scenario_path, error) : NULL;
    if (path == NULL)
    {
        (void)common_error_set(error, "out of memory");
    }
    free(path);
    return study;
}

char *sim_sweep_rows_path(const char *folder, uint64_t shard, uint64_t shards)
{
    return shards == 1 ? common_text_format("%s/rows.csv", folder)
                       : common_text_format("%s/rows-%" PRIu64 "-of-%" PRIu64 ".csv", folder, shard + 1, shards);
}

bool sim_sweep_forget_summary(const char *folder, common_error_t *error)
{
    common_output_file_t file = {.stream = NULL};
    char                *path = common_text_format("%s/summary.json", folder);
    const bool           ok   = (path != NULL || common_error_set(error, "out of memory")) &&
                    common_output_expect_none(&file, path, error) && common_output_commit(&file, 1, error);
    free(path);
    return ok;
}

static bool write_summary(const char *folder, const char *json, common_error_t *error)
{
    common_output_file_t file = {.stream = NULL};
    char                *path = common_text_format("%s/summary.json", folder);
    bool ok = (path != NULL || common_error_set(error, "out of memory")) && common_output_open(&file, path, error);
    if (ok)
    {
        (void)fprintf(file.stream, "%s\n", json);
        ok = common_output_commit(&file, 1, error);
    }
    free(path);
    return ok;
}

bool sim_sweep_report(const sim_study_t *study, const char *folder, common_error_t *error)
{
    char         *path   = sim_sweep_rows_path(folder, 0, 1);
    sim_report_t *report = path != NULL ? sim_report_read(study, path, error) : NULL;
    char         *json   = report != NULL ? sim_report_to_json(report) : NULL;
    bool          ok     = json != NULL || common_error_set(error, "out of memory"); // unless an error is set already
    if (ok)
    {
        sim_report_print(report);
        (void)printf("written: %s, %s/summary.json\n", path, folder);
        ok = write_summary(folder, json, error) && common_output_flush(error);
    }
    if (ok && sim_report_failed(report) > 0)
    {
        ok = common_error_set(error,
                              "%" PRIu64 " of %" PRIu64 " rows failed, the first: %s",
                              sim_report_failed(report),
                              study->rows,
                              sim_report_first_failure(report));
    }
    free(json);
    sim_report_free(report);
    free(path);
    return ok;
}
