/// A desk's plant, in place of all devices and lines of a rig: what firmware/desk gives to the program of this port.

#ifndef LINUX_DESK_H
#define LINUX_DESK_H

#include "loop/scenario.h"

typedef struct
{
    // The keys of a scenario with its plant, and the size of the struct that they are about, which begins with a common_loop_keys_t.
    const common_key_t *keys;
    size_t              size;
    bool (*check)(const common_scenario_t *scenario, common_error_t *error);

    /// A plant at rest; null with the cause in `error`. `scenario` outlives it.
    void *(*open)(const common_scenario_t *scenario, common_error_t *error);
    void (*close)(void *plant);

    double (*read)(void *plant);              ///< the sensor, in N
    void (*advance)(void *plant, double u_n); ///< by one tick, with u held
} desk_t;

#endif
