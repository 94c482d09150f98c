/// The Stribeck effect: friction of sliding as a part of breakaway, falling from 1 at rest to `sliding_ratio`.

#ifndef SIM_STRIBECK_H
#define SIM_STRIBECK_H

#include <math.h>

/// Gaussian, as in LuGre, Leuven and Maxwell slip: r + (1 - r) exp(-(w / ws)^2).
static inline double sim_stribeck(double sliding_ratio, double speed, double stribeck_speed)
{
    const double part = speed / stribeck_speed;
    return sliding_ratio == 1.0 ? 1.0 : sliding_ratio + (1.0 - sliding_ratio) * exp(-part * part);
}

#endif
