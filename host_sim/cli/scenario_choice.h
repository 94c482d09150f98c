/// Which scenario the command line asks for, and the folder of those that have a bare name: TRIBO_SCENARIOS if set, else
/// the source's, else the installed one.

#ifndef SIM_SCENARIO_CHOICE_H
#define SIM_SCENARIO_CHOICE_H

#include "scenario/config.h"

const char *sim_scenario_folder(void);

/// The path for what the user wrote: a file as it is, or else a bare name with or without ".yaml" in the folder. If there
/// is neither, the name itself (opening it gives the error). To be freed; null if there is no memory.
char *sim_scenario_path(const char *name);

typedef struct
{
    const char  *name; ///< as the user wrote it
    const char **sets; ///< the values of --set, in order
    int          set_count;
    const char  *learned; ///< a file with keys of `compensator`, between the scenario and the sets; null: none
} sim_scenario_choice_t;

/// Takes the value of a --set; 0, or the status to exit with.
int  sim_scenario_take_set(sim_scenario_choice_t *choice, const char *assignment);
void sim_scenario_choice_free(sim_scenario_choice_t *choice);

/// Loads what the user wrote, takes the values of --set, and checks it all. Null with the error filled in on failure.
sim_scenario_t *sim_scenario_open(const sim_scenario_choice_t *choice, sim_error_t *error);

#endif
