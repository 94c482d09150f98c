/// The commands of tribo-sim.

#ifndef SIM_COMMANDS_H
#define SIM_COMMANDS_H

#include "cli/options.h"

#define SIM_EXIT_OK    0
#define SIM_EXIT_ERROR 1 ///< the run, a file or a value
#define SIM_EXIT_USAGE 2 ///< the command line itself

extern const sim_command_t sim_command_run;
extern const sim_command_t sim_command_replay;
extern const sim_command_t sim_command_log;
extern const sim_command_t sim_command_params;
extern const sim_command_t sim_command_plot;
extern const sim_command_t sim_command_fmu;
extern const sim_command_t sim_command_list;

/// Reports a fault of the command line, or an error, on stderr; both return the exit status.
int sim_usage(const char *format, ...);
int sim_failure(const char *message);

#endif
