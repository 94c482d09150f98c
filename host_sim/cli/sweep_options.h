/// Shared by `sweep` and `merge`: the study, the folder, and the report at the end.

#ifndef SIM_SWEEP_OPTIONS_H
#define SIM_SWEEP_OPTIONS_H

#include "sweep/study.h"

/// Opens a study by its path, or by the name of one of the studies folder; null with the error filled in on failure.
sim_study_t *sim_sweep_open(const char *name, common_error_t *error);

/// The path of a folder's rows, of all or of a shard; to be freed, null if there is no memory.
char *sim_sweep_rows_path(const char *folder, uint64_t shard, uint64_t shards);

/// Removes the summary of an earlier sweep, which does not belong to this one.
bool sim_sweep_forget_summary(const char *folder, common_error_t *error);

/// Prints the summary of the folder's rows, and writes summary.json. False also if a row failed.
bool sim_sweep_report(const sim_study_t *study, const char *folder, common_error_t *error);

#endif
