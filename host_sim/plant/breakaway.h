/// Breakaway L(F) in both directions, double precision.

#ifndef SIM_BREAKAWAY_H
#define SIM_BREAKAWAY_H

#include "plant/truth_config.h"

typedef struct
{
    double positive_n, negative_n;
} sim_breakaway_t;

/// The negative direction's own offset and slope, or the positive one's.
double sim_breakaway_negative_offset(const sim_breakaway_config_t *config);
double sim_breakaway_negative_slope(const sim_breakaway_config_t *config);

/// L+ and L- at the applied force `force_n`.
sim_breakaway_t sim_breakaway_at(const sim_breakaway_config_t *config, double force_n);

#endif
