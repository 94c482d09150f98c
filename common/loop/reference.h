/// The reference r(t) in N.
///
///     triangle   low, up to high in half a period, back to low in the other; from start_s on, low before
///     sine       around the middle of low and high, upwards from it at start_s
///     step       low before start_s, high from then on
///     ramp       low before start_s, high ramp_s later
///     sawtooth   low to high in a period, then low at once
///     chirp      a sine whose frequency goes evenly from from_Hz to to_Hz in sweep_s, and stays
///     csv        columns t_s and r_N of a file, linear between its rows, its first and last value outside

#ifndef SIM_REFERENCE_H
#define SIM_REFERENCE_H

#include "loop/scenario.h"
#include "support/csv.h"

typedef struct
{
    sim_reference_config_t config;
    sim_csv_t              csv;
    size_t                 row; ///< where in the file the last call was
} sim_reference_t;

/// Reads the file, if the scenario has one. To be freed in any case.
bool sim_reference_init(sim_reference_t *reference, const sim_scenario_t *scenario, sim_error_t *error);
void sim_reference_free(sim_reference_t *reference);

/// r at `t_s`. Any time is right, but rising ones are fast.
double sim_reference_at(sim_reference_t *reference, double t_s);

/// Largest |r|.
double sim_reference_peak(const sim_reference_t *reference);

#endif
