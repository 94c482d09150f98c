/// The scenario on the command line. Bare names are found in common_scenario_folder().

#ifndef SIM_SCENARIO_CHOICE_H
#define SIM_SCENARIO_CHOICE_H

#include "scenario/config.h"

/// The path of `name`, as common_data_named finds it. The caller frees it; null if there is no memory.
char *sim_scenario_path(const char *name);

typedef struct
{
    const char  *name; ///< as the user wrote it
    const char **sets; ///< the values of --set, in order
    int          set_count;
    const char  *learned; ///< a file with keys of `compensator`, between the scenario and the sets; null: none
} sim_scenario_choice_t;

/// Takes the value of a --set; returns 0 or the exit status.
int  sim_scenario_take_set(sim_scenario_choice_t *choice, const char *assignment);
void sim_scenario_choice_free(sim_scenario_choice_t *choice);

/// Returns 0 if at most `most` of the values of --set set `arithmetic`, which --arith sets as well; otherwise the exit status.
int sim_scenario_check_arithmetic(const sim_scenario_choice_t *choice, int most);

/// Loads the scenario, applies the values of --set, and checks it all. Null with the error filled in on failure.
common_scenario_t *sim_scenario_open(const sim_scenario_choice_t *choice, common_error_t *error);

#endif
