#include "plant/drive_error.h"

#include "support/elementary.h"

#define TWO_PI 6.28318530717958647692

sim_ripple_t sim_drive_error_ripple(const sim_drive_error_t *error, double position_deg)
{
    if (error->ripple_n == 0.0)
    {
        return (sim_ripple_t){0};
    }
    const double per_deg = TWO_PI / error->ripple_period_deg;
    const double angle   = per_deg * position_deg + TWO_PI * error->ripple_phase;
    const double force   = error->ripple_n * common_sin(angle);
    return (sim_ripple_t){.force_n              = force,
                          .slope_n_per_deg      = error->ripple_n * per_deg * common_cos(angle),
                          .curvature_n_per_deg2 = -force * per_deg * per_deg};
}
