/// The plant of a desk, which replaces all devices and lines of a rig. firmware/desk passes it to the program of this port.

#ifndef LINUX_DESK_H
#define LINUX_DESK_H

#include "loop/scenario.h"

typedef struct
{
    // The keys of a scenario with its plant, and the size of their struct, which begins with a common_loop_keys_t.
    const common_key_t *keys;
    size_t              size;
    bool (*check)(const common_scenario_t *scenario, common_error_t *error);

    /// Creates a plant at rest; null with the cause in `error`. `scenario` outlives it.
    void *(*open)(const common_scenario_t *scenario, common_error_t *error);
    void (*close)(void *plant);

    double (*read)(void *plant);              ///< returns the sensor's reading in N
    void (*advance)(void *plant, double u_n); ///< advances the plant by one tick with u held
} desk_t;

#endif
