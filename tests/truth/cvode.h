/// A truth model's law integrated by SUNDIALS CVODE, with its root finding for changes of mode: the reference for the
/// plant's fixed steps. Open loop: u is a given function of time.

#ifndef TRUTH_CVODE_H
#define TRUTH_CVODE_H

#include "plant/drive_error.h"
#include "plant/truth/law.h"

#include <stdbool.h>

typedef struct
{
    double u_n, rate_n_per_s, rate_n_per_s2; ///< u and its first two derivatives
} cvode_drive_t;

typedef cvode_drive_t (*cvode_drive_at_t)(const void *context, double time_s);

typedef struct
{
    double relative_tolerance; ///< of all states
    double position_deg;       ///< absolute tolerances
    double speed_deg_per_s;
    double states;     ///< of the law's own states
    bool   adams;      ///< and fixed-point iteration, for non-stiff problems; otherwise backward
                       ///< differentiation and Newton's
    double max_step_s; ///< 0: no limit
} cvode_options_t;

/// Backward differentiation, 1e-8, and absolute tolerances far below a micronewton of F.
extern const cvode_options_t cvode_defaults;

typedef struct
{
    long   steps, right_hand_sides, events; ///< right-hand sides include those of Jacobians
    double seconds;                         ///< processor time
} cvode_cost_t;

typedef struct cvode cvode_t;

/// Creates a reference at rest at F = 0 and time 0; null if there is no memory. Copies the config, but not its breakaway table.
cvode_t *cvode_create(const sim_truth_ops_t *truth, const sim_truth_config_t *config, const cvode_options_t *options);

/// Sets errors of the drive, initially none. Without an actuator here, those of the command act at once. Call before the first
/// drive.
void cvode_set_drive_error(cvode_t *reference, const sim_drive_error_t *error);
void cvode_destroy(cvode_t *reference);

/// From now to `until_s` u is `at(context, time)`, smooth. Call at the start and at each kink of the input.
bool cvode_drive(cvode_t *reference, cvode_drive_at_t at, const void *context, double until_s);

/// Integrates to `time_s`, within the drive's span. False if CVODE gave up or modes changed without end; then
/// cvode_problem says which.
bool        cvode_advance(cvode_t *reference, double time_s);
const char *cvode_problem(const cvode_t *reference);

double       cvode_force(const cvode_t *reference);
double       cvode_speed(const cvode_t *reference);
double       cvode_friction(const cvode_t *reference);
cvode_cost_t cvode_cost(const cvode_t *reference);

#endif
