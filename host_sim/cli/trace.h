/// trace.csv: one row a tick, nine significant digits. A replay has its compensator's columns, too.

#ifndef SIM_TRACE_H
#define SIM_TRACE_H

#include "scenario/columns.h"

#include <stdio.h>

/// Includes the learned columns if it `learns`.
void sim_trace_write_header(FILE *file, bool learns);
void sim_trace_write_row(FILE *file, const sim_row_t *row);

/// ",F_hat_N,n_N" and so on.
#define SIM_TRACE_NAME(name, value) "," #name
#define SIM_TRACE_COMPENSATOR       SIM_COMPENSATOR_COLUMNS(SIM_TRACE_NAME, SIM_TRACE_NAME)

/// Likewise, each value behind a comma.
void sim_trace_write_compensator(FILE *file, const tribo_compensator_f32_signals_t *signals);

#endif
