/// What a scenario under construction holds. For the files of this folder only.

#ifndef SIM_SCENARIO_DATA_H
#define SIM_SCENARIO_DATA_H

#include "scenario/config.h"
#include "scenario/source.h"

struct sim_scenario
{
    sim_config_t *config;
    sim_sources_t sources;
    char         *path; ///< of the file; null if there is none
};

#endif
