/// The folder of scenarios: TRIBO_SCENARIOS if set, else the source's, else the installed one.

#ifndef SIM_SCENARIO_FOLDER_H
#define SIM_SCENARIO_FOLDER_H

#include "scenario/config.h"

const char *sim_scenario_folder(void);

/// The path for what the user wrote: a file as it is, or else a bare name with or without ".yaml" in the folder. If there
/// is neither, the name itself (opening it gives the error). To be freed; null if there is no memory.
char *sim_scenario_path(const char *name);

/// Loads what the user wrote, takes the values of --set in their order, and checks it all.
bool sim_scenario_open(sim_scenario_t *scenario,
                       const char     *name,
                       char *const    *sets,
                       int             set_count,
                       sim_error_t    *error);

#endif
