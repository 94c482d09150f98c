/// trace.csv: one row a tick, nine significant digits. A replay has its compensator's columns, too.

#ifndef SIM_TRACE_H
#define SIM_TRACE_H

#include "scenario/columns.h"
#include "support/error.h"

#include <stdio.h>

/// Which columns and rows to write; all zeros: all of them.
typedef struct
{
    uint64_t every; ///< of so many rows the first
    bool     is_chosen;
    bool     has[SIM_COLUMNS_MAX]; ///< if some are chosen
} sim_trace_choice_t;

/// Takes names with commas between; t_s is always among them. False with the error filled in for one that is none.
bool sim_trace_choose(sim_trace_choice_t *choice, const char *list, common_error_t *error);

/// False with the error filled in where a column is chosen that only a run with learning has.
bool sim_trace_check(const sim_trace_choice_t *choice, bool learns, common_error_t *error);

/// Includes the learned columns if it `learns`.
void sim_trace_write_header(FILE *file, const sim_trace_choice_t *choice, bool learns);
void sim_trace_write_row(FILE *file, const sim_trace_choice_t *choice, const sim_row_t *row);

/// ",F_hat_N,n_N" and so on.
#define SIM_TRACE_NAME(name, value) "," #name
#define SIM_TRACE_COMPENSATOR       SIM_COMPENSATOR_COLUMNS(SIM_TRACE_NAME, SIM_TRACE_NAME)

/// Likewise, each value behind a comma.
void sim_trace_write_compensator(FILE *file, const tribo_compensator_f32_signals_t *signals);

#endif
