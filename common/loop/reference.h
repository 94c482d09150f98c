/// The reference r(t) in N.
///
///     triangle   low, up to high in half a period, back to low in the other; from start_s on, low before
///     sine       around the middle of low and high, upwards from it at start_s
///     step       low before start_s, high from then on
///     ramp       low before start_s, high ramp_s later
///     sawtooth   low to high in a period, then low at once
///     chirp      a sine whose frequency rises linearly from from_Hz to to_Hz in sweep_s, then stays
///     csv        columns t_s and r_N of a file, linear between its rows, its first and last value outside

#ifndef COMMON_REFERENCE_H
#define COMMON_REFERENCE_H

#include "loop/scenario.h"
#include "support/csv.h"

typedef struct
{
    common_reference_config_t config;
    common_csv_t              csv;
    size_t                    row; ///< of the file, where the last call ended
} common_reference_t;

/// Reads the file, if the scenario has one. To be freed in any case.
bool common_reference_init(common_reference_t *reference, const common_scenario_t *scenario, common_error_t *error);
void common_reference_free(common_reference_t *reference);

/// r at `t_s`. Times may come in any order; rising ones are fast.
double common_reference_at(common_reference_t *reference, double t_s);

/// Largest |r|.
double common_reference_peak(const common_reference_t *reference);

#endif
