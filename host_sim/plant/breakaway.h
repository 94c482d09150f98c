/// Computes breakaway L(F) in both directions, in double precision.

#ifndef SIM_BREAKAWAY_H
#define SIM_BREAKAWAY_H

#include "plant/truth_config.h"

#include <math.h>

typedef struct
{
    double positive_n, negative_n;
} sim_breakaway_t;

/// Returns L+ and L- from the table at the magnitude `force_n`: linear between the points, constant outside.
sim_breakaway_t sim_breakaway_look_up(const common_breakaway_config_t *config, double force_n);

/// Returns L+ and L- at the applied force `force_n`. It is inline because the truth models call it in every step.
static inline sim_breakaway_t sim_breakaway_at(const common_breakaway_config_t *config, double force_n)
{
    const double force = fabs(force_n);
    if (config->table_count > 0)
    {
        return sim_breakaway_look_up(config, force);
    }
    return (sim_breakaway_t){config->offset_n + config->slope * force,
                             common_breakaway_negative_offset(config) +
                                 common_breakaway_negative_slope(config) * force};
}

#endif
