/// trace.csv: one row a tick, nine significant digits. A replay has its compensator's columns, too.

#ifndef SIM_TRACE_H
#define SIM_TRACE_H

#include "scenario/runner.h"

#include <stdio.h>

/// Includes the learned columns if it `learns`.
void sim_trace_write_header(FILE *file, bool learns);
void sim_trace_write_row(FILE *file, const sim_row_t *row);

#define SIM_TRACE_COMPENSATOR "F_hat_N,n_N,L_N,v_N_per_s,Q1,Q2,Q,f_hat_N"

void sim_trace_write_compensator(FILE *file, const tribo_compensator_f32_signals_t *signals);

#endif
