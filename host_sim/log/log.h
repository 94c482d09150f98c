/// Reads recorded logs with any column names, units, scales and signs, with jitter and gaps, several files as one experiment.
///
///     value = scale * unit * field + bias          per column, in N, s, m or deg
///
/// Stamps must be even within 1 % of the median interval, or as even as their digits allow: rounded stamps of an even clock
/// are replaced by those of that clock. Other logs are refused, or resampled: linearly between rows, at the median interval.
/// A gap of more than `gap_s` is not bridged but splits the log into segments. Each file begins a segment; if its stamps do
/// not follow those of the file before, they are shifted to begin one second after them.

#ifndef SIM_LOG_H
#define SIM_LOG_H

#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>

#define SIM_LOG_FILES_MAX 64u

typedef enum
{
    SIM_LOG_T, ///< time
    SIM_LOG_U, ///< command, as end-point force
    SIM_LOG_F, ///< end-point force
    SIM_LOG_X, ///< position; its changes give the direction of motion
    SIM_LOG_V, ///< speed; gives the direction of motion
    SIM_LOG_R, ///< reference of the force
    SIM_LOG_ROLES
} sim_log_role_t;

/// How a column is read. All zeros mean the default name and unit.
typedef struct
{
    const char *name;  ///< null: t_s, u_N, F_N (or y_N), x_deg, w_deg_per_s, r_N; "#3" is the third
    double      unit;  ///< size of the field's unit, in s or N; 0: 1
    double      scale; ///< 0: 1
    double      bias;
    bool        is_torque; ///< the unit is that of a torque, so a scale is required
    const char *option,
        *text; ///< of the command line: the option that requires the column, for the message; null: none
} sim_log_column_t;

typedef struct
{
    sim_log_column_t columns[SIM_LOG_ROLES];
    bool             command_optional;
    bool             resample;
    double           gap_s;  ///< longest gap to bridge; 0: ten intervals
    double           rate_s; ///< interval of resampling; 0: the median
} sim_log_options_t;

/// Irregularities found, and the repairs.
typedef struct
{
    size_t rows_read, files;
    size_t jittery;        ///< intervals off by more than 1 %
    size_t gaps;           ///< intervals of more than 1.5 times the median
    size_t repeated;       ///< rows with repeated stamps, which are left out
    size_t moved_rows;     ///< rows whose stamps went back, which are put in order
    size_t left_out;       ///< broken rows, which are bridged linearly
    char  *left_out_first; ///< message about the first of them; null: there is none
    size_t splits;         ///< gaps at which the log was split
    size_t moved;          ///< files whose stamps were moved
    double largest_s;      ///< largest interval
    double last_place_s;   ///< last place of stamps that are even except for their rounding; otherwise 0
    bool   resampled;
} sim_log_report_t;

typedef struct
{
    size_t           rows, segments;
    double           sample_time_s;
    double          *values[SIM_LOG_ROLES]; ///< null: no such column
    size_t          *starts;                ///< first rows of the segments, then `rows`
    sim_log_report_t report;
} sim_log_t;

/// Sets a column's name from "u=torque_cmd", its unit from "u=mN", its scale from "u=0.5" or "u=-", or its bias from
/// "u=-0.1"; each requires the column. `text` must outlive the options. Returns false with the error filled in.
bool sim_log_set_column(sim_log_options_t *options, const char *text, common_error_t *error);
bool sim_log_set_unit(sim_log_options_t *options, const char *text, common_error_t *error);
bool sim_log_set_scale(sim_log_options_t *options, const char *text, common_error_t *error);
bool sim_log_set_bias(sim_log_options_t *options, const char *text, common_error_t *error);

/// Reads `count` files, 1 to SIM_LOG_FILES_MAX. On failure nothing is left to free.
bool sim_log_read(sim_log_t               *log,
                  const char *const       *paths,
                  size_t                   count,
                  const sim_log_options_t *options,
                  common_error_t          *error);

void sim_log_free(sim_log_t *log);

#endif
