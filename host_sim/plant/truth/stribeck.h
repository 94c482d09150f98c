/// The Stribeck effect: sliding friction as a fraction of breakaway, falling from 1 at rest to `sliding_ratio`.

#ifndef SIM_STRIBECK_H
#define SIM_STRIBECK_H

#include "plant/truth.h"
#include "support/elementary.h"

/// Returns the Gaussian curve of LuGre, Leuven and Maxwell slip: r + (1 - r) exp(-(w / ws)^2).
static inline double sim_stribeck(double sliding_ratio, double speed, double stribeck_speed)
{
    const double part = speed / stribeck_speed;
    return sliding_ratio == 1.0 ? 1.0 : sliding_ratio + (1.0 - sliding_ratio) * common_exp(-part * part);
}

/// The keys of its two parameters, members of `type`.
// clang-format off
#define SIM_STRIBECK_KEYS(type)                                                                                        \
    SIM_TRUTH_NUMBER(type, sliding_ratio, "sliding_ratio", "-", 0.1, 1.0, 1.0, "friction of sliding divided by breakaway"),  \
    SIM_TRUTH_NUMBER(type, stribeck_speed, "stribeck_speed_deg_per_s", "deg/s", 1e-5, 100.0, 0.01,                     \
                     "speed at which the Stribeck effect has fallen to 1/e")
// clang-format on

#endif
