/// A scenario's values as the configuration of its plant.

#ifndef SIM_PLANT_CONFIG_H
#define SIM_PLANT_CONFIG_H

#include "plant/plant.h"
#include "scenario/config.h"

/// Plant steps in a sample, of a checked scenario.
unsigned sim_plant_steps(const sim_config_t *config);

/// Points into `config`, which must outlive it.
sim_plant_config_t sim_plant_config_of(const sim_config_t *config);

#endif
