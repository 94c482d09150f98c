/// Errors between the command and the arm, the same for every truth model: scale and bias of the command (torque constant,
/// current offset), and a torque ripple periodic in position (cogging, gear mesh), which on real gears exceeds L:
///
///     actuator input  (1 + scale) u + bias        arm's drive  u_a + ripple sin(2 pi (theta / period + phase))
///
/// The errors; all zeros for a drive without errors.

#ifndef SIM_DRIVE_ERROR_H
#define SIM_DRIVE_ERROR_H

typedef struct
{
    double scale; ///< relative error
    double bias_n;
    double ripple_n;
    double ripple_period_deg;
    double ripple_phase; ///< phase, in periods
} sim_drive_error_t;

/// Returns the actuator's input for the command `u_n`.
static inline double sim_drive_error_command(const sim_drive_error_t *error, double u_n)
{
    return (1.0 + error->scale) * u_n + error->bias_n;
}

/// Returns the ripple at a position, in N, and its first and second derivative with respect to position.
typedef struct
{
    double force_n, slope_n_per_deg, curvature_n_per_deg2;
} sim_ripple_t;

sim_ripple_t sim_drive_error_ripple(const sim_drive_error_t *error, double position_deg);

#endif
