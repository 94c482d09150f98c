/// The commands of tribo-sim. Each takes the arguments after its own name and returns the exit status.

#ifndef SIM_COMMANDS_H
#define SIM_COMMANDS_H

#define SIM_EXIT_OK    0
#define SIM_EXIT_ERROR 1 ///< the run, a file or a value
#define SIM_EXIT_USAGE 2 ///< the command line itself

/// `arguments[0]` is the command's name, as in main.
int sim_command_run(int count, char **arguments);
int sim_command_replay(int count, char **arguments);
int sim_command_params(int count, char **arguments);
int sim_command_list(int count, char **arguments);

/// Says on stderr what is wrong with the command line, or shows the error; returns the status to exit with.
int sim_usage(const char *format, ...);
int sim_failure(const char *message);

#endif
