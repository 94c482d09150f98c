/// trace.csv: one row a tick, nine significant digits.

#ifndef SIM_TRACE_H
#define SIM_TRACE_H

#include "scenario/runner.h"

#include <stdio.h>

void sim_trace_write_header(FILE *file);
void sim_trace_write_row(FILE *file, const sim_row_t *row);

#endif
