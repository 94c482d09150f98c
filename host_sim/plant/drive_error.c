#include "plant/drive_error.h"

#include <math.h>

#define TWO_PI 6.28318530717958647692

const sim_key_t sim_drive_error_keys[] = {
    SIM_TRUTH_KEY(0, "scale", "-", -0.9, 9.0, 0.0, "error of the command's scale"),
    SIM_TRUTH_KEY(1, "bias_N", "N", -1.0, 1.0, 0.0, "added to the command"),
    SIM_TRUTH_KEY(2, "ripple_N", "N", 0.0, 2.0, 0.0, "amplitude of the torque ripple"),
    // The arm moves by 0.26 deg for 1 N.
    SIM_TRUTH_KEY(3, "ripple_period_deg", "deg", 1e-3, 360.0, 0.1, "of the ripple, in position"),
    SIM_TRUTH_KEY(4, "ripple_phase", "-", 0.0, 1.0, 0.0, "of the ripple at F = 0, in periods"),
    {0},
};
double sim_drive_error_command(const sim_drive_error_t *error, double u_n)
{
    return (1.0 + error->scale) * u_n + error->bias_n;
}

sim_ripple_t sim_drive_error_ripple(const sim_drive_error_t *error, double position_deg)
{
    if (error->ripple_n == 0.0)
    {
        return (sim_ripple_t){0};
    }
    const double per_deg = TWO_PI / error->ripple_period_deg;
    const double angle   = per_deg * position_deg + TWO_PI * error->ripple_phase;
    const double force   = error->ripple_n * sin(angle);
    return (sim_ripple_t){.force_n              = force,
                          .slope_n_per_deg      = error->ripple_n * per_deg * cos(angle),
                          .curvature_n_per_deg2 = -force * per_deg * per_deg};
}
