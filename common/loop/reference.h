/// The reference r(t) in N.
///
///     triangle   low before start_s, then up to high in half a period and back to low in the other half
///     sine       around the middle of low and high, rising from it at start_s
///     step       low before start_s, high from then on
///     ramp       low before start_s, high ramp_s later
///     sawtooth   low to high in a period, then low at once
///     chirp      a sine whose frequency rises linearly from from_Hz to to_Hz in sweep_s, then stays
///     csv        columns t_s and r_N of a file, linear between its rows; its first and last value outside

#ifndef COMMON_REFERENCE_H
#define COMMON_REFERENCE_H

#include "loop/scenario.h"
#include "support/csv.h"

typedef struct
{
    common_reference_config_t config;
    common_csv_t              csv;
    size_t                    row; ///< row of the file at which the last call ended
} common_reference_t;

/// Makes the reference of a scenario and reads its file, if it has one. Free it even after a failure.
bool common_reference_init(common_reference_t *reference, const common_scenario_t *scenario, common_error_t *error);
void common_reference_free(common_reference_t *reference);

/// Returns r at `t_s`. Times may come in any order; rising times are fast.
double common_reference_at(common_reference_t *reference, double t_s);

/// Returns the largest |r|.
double common_reference_peak(const common_reference_t *reference);

#endif
