/// Prints the library's list of parameters for people: `tribo-sim list --parameters`.

#ifndef SIM_PARAMETER_LIST_H
#define SIM_PARAMETER_LIST_H

/// Prints a table in Markdown for each config to standard output.
void sim_parameter_list_print(void);

#endif
