/// Summary of a study's rows: quantiles of each measure, how often the base run is worse than the run with `without`, and the
/// worst rows with commands that play them.

#ifndef SIM_REPORT_H
#define SIM_REPORT_H

#include "support/error.h"
#include "sweep/study.h"

#define SIM_REPORT_WORST 10u

typedef struct sim_report sim_report_t;

/// From the complete rows of the study's file at `path`. Null with the error filled in.
sim_report_t *sim_report_read(const sim_study_t *study, const char *path, common_error_t *error);
void          sim_report_free(sim_report_t *report);

/// The number of rows without a result, and the message of the first: "row 17: ...".
uint64_t    sim_report_failed(const sim_report_t *report);
const char *sim_report_first_failure(const sim_report_t *report);

/// On standard output.
void sim_report_print(const sim_report_t *report);

/// As JSON, to be freed; null if there is no memory. docs/sweep.md has the keys.
char *sim_report_to_json(const sim_report_t *report);

#endif
