/// The command line of a command: argp parses it and writes the help, both from one table; the messages are our own.

#ifndef SIM_OPTIONS_H
#define SIM_OPTIONS_H

#include <argp.h>
#include <stdbool.h>

/// A command of tribo-sim.
typedef struct
{
    const char *name;     ///< "run"
    const char *argument; ///< its argument, as shown in the help; null: none
    const char *noun;     ///< the same in a message: "one NOUN is expected"
    const char *text;     ///< the help's description
    bool        is_many;  ///< one or more arguments, each passed to `take` as SIM_OPTION_ARGUMENT

    /// Keys count from SIM_OPTION_FIRST. sim_option_word chooses from an `arg` of words ("f32|q31").
    const struct argp_option *options;

    /// Runs it; returns the exit status. `arguments[0]` is the command's name.
    int (*run)(int count, char **arguments);

    /// Takes one option into `context`; returns 0 or the exit status.
    int (*take)(void *context, int key, const char *value);
} sim_command_t;

#define SIM_OPTION_FIRST    256 ///< argp reads smaller keys as letters
#define SIM_OPTION_ARGUMENT 1   ///< the key of an argument where a command takes many

/// Takes all options; `*argument` is the command's argument (null where it takes many). Returns 0 or the exit status.
int sim_options_parse(const sim_command_t *command, int count, char **arguments, void *context, const char **argument);

/// The index of `value` among the words of option `key`; negative, with a message, if it is not among them.
int sim_option_word(const sim_command_t *command, int key, const char *value);

/// Prints the help of a command on standard output.
void sim_options_help(const sim_command_t *command);

#endif
