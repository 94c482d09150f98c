/// A study's rows: each is one run, or two of them, with and without what the study calls `without`.

#ifndef SIM_SWEEP_H
#define SIM_SWEEP_H

#include "scenario/summary.h"
#include "sweep/study.h"

/// The columns' names, from `study` and `row` to `message`, with commas between; to be freed, null if there is no memory.
char *sim_sweep_header(const sim_study_t *study);

/// A run that several rows in a row have in common.
typedef struct
{
    char         *assignments; ///< null: none yet
    sim_summary_t summary;
} sim_sweep_last_t;

/// Plays a row. The text of its columns behind `row`, to be freed; null if there is no memory. A run that fails is in it, with its message.
/// `last` keeps the run without, all zeros to begin with. `*simulated_s` grows.
char *sim_sweep_row(const sim_study_t *study, uint64_t row, sim_sweep_last_t *last, double *simulated_s);

/// The same for a row that could not be played to its end: its status is `status`.
char *sim_sweep_failed_row(const sim_study_t *study, uint64_t row, const char *status, const char *message);

/// What the columns of a run are called.
#define SIM_SWEEP_MEASURES 10u
extern const char *const sim_sweep_measures[SIM_SWEEP_MEASURES];

#endif
