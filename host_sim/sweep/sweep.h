/// A study's rows: each is one run, or two, the second with the assignments of the study's `without`.

#ifndef SIM_SWEEP_H
#define SIM_SWEEP_H

#include "scenario/summary.h"
#include "sweep/study.h"

/// The columns' names, from `study` and `row` to `message`, with commas between; to be freed, null if there is no memory.
char *sim_sweep_header(const sim_study_t *study);

/// A run shared by consecutive rows.
typedef struct
{
    char         *assignments; ///< null: none yet
    sim_summary_t summary;
} sim_sweep_last_t;

/// Plays a row. Returns the text of its columns after `row`, to be freed; null if there is no memory. A failed run is in it,
/// with its message. `last` keeps the run with `without`; start with all zeros. Adds to `*simulated_s`.
char *sim_sweep_row(const sim_study_t *study, uint64_t row, sim_sweep_last_t *last, double *simulated_s);

/// The same for a row that did not finish, with this `status`.
char *sim_sweep_failed_row(const sim_study_t *study, uint64_t row, const char *status, const char *message);

/// Names of the columns of a run.
#define SIM_SWEEP_MEASURES 10u
extern const char *const sim_sweep_measures[SIM_SWEEP_MEASURES];

#endif
