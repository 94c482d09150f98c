/// A replayed log as an SVG of four panels: u and F; n, f and +-L; n - f; and n over F with +-L(F).

#ifndef SIM_PLOT_H
#define SIM_PLOT_H

#include "log/verdict.h"

#include <stdio.h>

/// Writes it. `log` has a force.
void sim_plot_write(FILE *file, const char *title, const sim_log_t *log, const sim_replayed_t *replayed);

#endif
