/// trace.csv: one row a tick, nine significant digits. A replay has its compensator's columns, too.

#ifndef SIM_TRACE_H
#define SIM_TRACE_H

#include "scenario/columns.h"
#include "support/error.h"

#include <stdio.h>

/// Which columns and rows to write; all zeros: all of them.
typedef struct
{
    uint64_t every; ///< writes the first of so many rows
    bool     is_chosen;
    bool     has[SIM_COLUMNS_MAX]; ///< if some are chosen
} sim_trace_choice_t;

/// Takes names separated by commas; t_s is always among them. Returns false with the error filled in for an unknown name.
bool sim_trace_choose(sim_trace_choice_t *choice, const char *list, common_error_t *error);

/// Returns false with the error filled in if a chosen column exists only in a run with learning.
bool sim_trace_check(const sim_trace_choice_t *choice, bool learns, common_error_t *error);

/// Includes the learned columns if it `learns`.
void sim_trace_write_header(FILE *file, const sim_trace_choice_t *choice, bool learns);
void sim_trace_write_row(FILE *file, const sim_trace_choice_t *choice, const sim_row_t *row);

/// ",F_hat_N,n_N" and so on.
#define SIM_TRACE_NAME(name, value) "," #name
#define SIM_TRACE_COMPENSATOR       SIM_COMPENSATOR_COLUMNS(SIM_TRACE_NAME, SIM_TRACE_NAME)

/// Writes the values of these columns, each after a comma.
void sim_trace_write_compensator(FILE *file, const tribo_compensator_f32_signals_t *signals);

#endif
