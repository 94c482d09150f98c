/// The folder of scenarios: TRIBO_SCENARIOS if set, else the source's, else the installed one.

#ifndef SIM_SCENARIO_FOLDER_H
#define SIM_SCENARIO_FOLDER_H

const char *sim_scenario_folder(void);

/// The path for what the user wrote: a file as it is, or else a bare name with or without ".yaml" in the folder. If there
/// is neither, the name itself (opening it gives the error). To be freed; null if there is no memory.
char *sim_scenario_path(const char *name);

#endif
