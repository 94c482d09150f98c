/// The command line of a command: argp parses it and writes the help, both from one table, with messages of our own.

#ifndef SIM_OPTIONS_H
#define SIM_OPTIONS_H

#include <argp.h>
#include <stdbool.h>

/// A command of tribo-sim.
typedef struct
{
    const char *name;     ///< "run"
    const char *argument; ///< what it is about, as the help shows it; null: nothing
    const char *noun;     ///< the same in a message: "one NOUN is wanted"
    const char *text;     ///< what it does, for the help
    bool        is_many;  ///< one argument or more, each given to `take` as SIM_OPTION_ARGUMENT

    /// Keys count from SIM_OPTION_FIRST. An `arg` of words ("f32|q31") is what sim_option_word chooses from.
    const struct argp_option *options;

    /// Runs it; returns the exit status. `arguments[0]` is the command's name.
    int (*run)(int count, char **arguments);

    /// Takes one option into `context`; 0, or the status to exit with.
    int (*take)(void *context, int key, const char *value);
} sim_command_t;

#define SIM_OPTION_FIRST    256 ///< below it argp takes a key for a letter
#define SIM_OPTION_ARGUMENT 1   ///< the key of an argument of a command that takes many

/// Takes all options and puts the command's argument into `*argument` (null for a command of many); 0, or the status to exit with.
int sim_options_parse(const sim_command_t *command, int count, char **arguments, void *context, const char **argument);

/// The index of `value` among the words of option `key`; less than 0 is not one of them, and said so.
int sim_option_word(const sim_command_t *command, int key, const char *value);

/// Prints the help of a command on standard output.
void sim_options_help(const sim_command_t *command);

#endif
