/// Converts a scenario's values to the configuration of its plant.

#ifndef SIM_PLANT_CONFIG_H
#define SIM_PLANT_CONFIG_H

#include "plant/plant.h"
#include "scenario/config.h"

/// Returns the plant steps in a sample, for a checked scenario.
unsigned sim_plant_steps(const sim_config_t *config);

/// Returns the plant's configuration. It points into `config`, which must outlive it.
sim_plant_config_t sim_plant_config_of(const sim_config_t *config);

#endif
