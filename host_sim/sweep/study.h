/// A study: a scenario, and those of its keys that vary from run to run. docs/sweep.md describes its file.
///
/// Rows are numbered from 0: all combinations of the grid for the first sample, then for the second, and so on. A row's values
/// depend on the study and the row alone, not on the worker.

#ifndef SIM_STUDY_H
#define SIM_STUDY_H

#include "scenario/config.h"

#include <stdint.h>

#define SIM_STUDY_AXES_MAX 64u
#define SIM_STUDY_KEYS_MAX 16u      ///< of one axis
#define SIM_STUDY_RUNS_MAX 1000000u ///< samples
#define SIM_STUDY_ROWS_MAX 10000000u

/// One "key=value", and its place in the study's file.
typedef struct
{
    char  *assignment;
    size_t line, column;
} sim_setting_t;

typedef struct
{
    sim_setting_t *entry;
    size_t         count;
} sim_settings_t;

/// A value of an axis with a list of values.
typedef struct
{
    char          *label; ///< in the axis's column
    sim_settings_t settings;
} sim_case_t;

typedef enum
{
    SIM_AXIS_LIST,
    SIM_AXIS_UNIFORM,
    SIM_AXIS_LOG_UNIFORM,
    SIM_AXIS_NORMAL
} sim_axis_kind_t;

typedef struct
{
    char           *name;
    size_t          line, column;
    sim_axis_kind_t kind;
    sim_case_t     *cases; ///< of a list
    size_t          count; ///< of cases, or of points in a grid

    double   a, b;      ///< from, to; or mean, standard deviation
    double   low, high; ///< bounds of a truncated normal distribution, if `is_cut`
    char    *keys[SIM_STUDY_KEYS_MAX];
    double   base[SIM_STUDY_KEYS_MAX]; ///< the scenario's own values, if the axis is relative to them
    unsigned key_count;
    bool     relative, whole, is_cut;
    double  *probability; ///< of a sampled axis, by sample: from 0 to 1
} sim_axis_t;

typedef struct
{
    char    *path;     ///< of the study's file
    char    *scenario; ///< its path
    bool     q31;
    bool     is_paired; ///< each row is run a second time, with `without`
    double   timeout_s; ///< of CPU time for a row
    uint64_t seed;
    bool     latin;

    sim_settings_t set, without;
    sim_axis_t    *axes[SIM_STUDY_AXES_MAX]; ///< the grid's, then the sampled ones
    unsigned       grid_count, axis_count;
    uint64_t       samples, grid_rows, rows;
    uint32_t       id; ///< of all inputs of the rows: the files of study, scenario and reference, and the version
} sim_study_t;

/// Finds a scenario by the name in a study; to be freed, null if there is no memory.
typedef char *(*sim_scenario_finder_t)(const char *name);

/// Reads a study and checks every key and every value in it. Null with the error filled in on failure.
sim_study_t *sim_study_open(const char *path, sim_scenario_finder_t find, common_error_t *error);
void         sim_study_close(sim_study_t *study);

/// The scenario of a row, checked; null with the error filled in.
common_scenario_t *sim_study_scenario(const sim_study_t *study, uint64_t row, bool without, common_error_t *error);

/// The row's entry in an axis's column, in `text`.
void sim_study_label(const sim_study_t *study, uint64_t row, unsigned axis, char *text, size_t size);

/// All "key=value" of a row, each key once with its last value: separated by '\n', to be freed; null if there is no memory.
char *sim_study_assignments(const sim_study_t *study, uint64_t row, bool without);

/// A shell command that plays a row; to be freed, null if there is no memory.
char *sim_study_command(const sim_study_t *study, uint64_t row, bool without);

#endif
