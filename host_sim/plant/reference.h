/// A truth model's law integrated by SUNDIALS CVODE, with its root finding for the changes of mode: the reference for the
/// plant's fixed steps. Open loop: u is a given function of time. A library of its own, tribo_reference, as only tests
/// and measurements need it.

#ifndef SIM_REFERENCE_H
#define SIM_REFERENCE_H

#include "plant/drive_error.h"
#include "plant/truth/law.h"

#include <stdbool.h>

typedef struct
{
    double u_n, rate_n_per_s, rate_n_per_s2; ///< u and its first two derivatives
} sim_drive_t;

typedef sim_drive_t (*sim_drive_at_t)(const void *context, double time_s);

typedef struct
{
    double relative_tolerance; ///< of all states
    double position_deg;       ///< absolute tolerances
    double speed_deg_per_s;
    double states;     ///< of the law's own states
    bool   adams;      ///< and fixed-point iteration, for problems that are not stiff; otherwise backward
                       ///< differentiation and Newton's
    double max_step_s; ///< 0: no limit
} sim_reference_options_t;

/// Backward differentiation, 1e-8, and absolute tolerances far below what moves F by a micronewton.
extern const sim_reference_options_t sim_reference_defaults;

typedef struct
{
    long   steps, right_hand_sides, events; ///< right-hand sides include those of Jacobians
    double seconds;                         ///< processor time
} sim_reference_cost_t;

typedef struct sim_reference sim_reference_t;

/// At rest at F = 0 and time 0. Null if there is no memory. The config is copied, but not its breakaway table.
sim_reference_t *sim_reference_create(const sim_truth_ops_t         *truth,
                                      const sim_truth_config_t      *config,
                                      const sim_reference_options_t *options);

/// Errors of the drive, none at first; of the command, there being no actuator here, at once. Before the first drive.
void sim_reference_set_drive_error(sim_reference_t *reference, const sim_drive_error_t *error);
void sim_reference_destroy(sim_reference_t *reference);

/// From now to `until_s` u is `at(context, time)`, smooth. To be called at the start and at each break of the input.
bool sim_reference_drive(sim_reference_t *reference, sim_drive_at_t at, const void *context, double until_s);

/// Integrates to `time_s`, within the drive's span. False if CVODE gave up or modes changed without end; then
/// sim_reference_problem says which.
bool        sim_reference_advance(sim_reference_t *reference, double time_s);
const char *sim_reference_problem(const sim_reference_t *reference);

double               sim_reference_force(const sim_reference_t *reference);
double               sim_reference_speed(const sim_reference_t *reference);
double               sim_reference_friction(const sim_reference_t *reference);
sim_reference_cost_t sim_reference_cost(const sim_reference_t *reference);

#endif
