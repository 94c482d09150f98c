#include "sim/options.h"

#include "sim/commands.h"
#include "support/options.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#define OPTION_LAST 0xffff // argp's own keys are far above

typedef struct
{
    const sim_command_t *command;
    void                *context;
    const char          *argument;
    int                  arguments;
    int                  status; ///< to exit with; 0: no fault yet
} parse_t;

/// True if the word is an option or the start of one: the value before it is missing.
static bool is_option(const sim_command_t *command, const char *word)
{
    const struct argp_option *option = command->options;
    while (option->name != NULL && (strncmp(word, "--", 2) != 0 || strstr(option->name, word + 2) != option->name))
    {
        option++;
    }
    return option->name != NULL;
}

static int complain_about(const sim_command_t *command, const char *word)
{
    return is_option(command, word) ? sim_usage("%s: %s needs a value", command->name, word)
                                    : sim_usage("%s: unknown option %s", command->name, word);
}

static error_t take(int key, char *value, struct argp_state *state)
{
    common_error_t       error   = {""};
    parse_t             *parse   = state->input;
    const sim_command_t *command = parse->command;
    if (key == ARGP_KEY_ARG)
    {
        parse->argument = value;
        parse->arguments++;
        parse->status = command->is_many ? command->take(parse->context, SIM_OPTION_ARGUMENT, value) : 0;
        return parse->status == 0 ? 0 : EINVAL;
    }
    if (key >= SIM_OPTION_FIRST && key <= OPTION_LAST)
    {
        parse->status = common_options_add(command->options, key, value, &error)
                            ? command->take(parse->context, key, value)
                            : sim_usage("%s: %s", command->name, error.text);
        return parse->status == 0 ? 0 : EINVAL;
    }
    if (key == ARGP_KEY_ERROR && parse->status == 0)
    {
        parse->status = complain_about(command, state->argv[state->next - 1]);
    }
    return ARGP_ERR_UNKNOWN;
}

int sim_options_parse(const sim_command_t *command, int count, char **arguments, void *context, const char **argument)
{
    const struct argp argp  = {.options = command->options, .parser = take};
    parse_t           parse = {.command = command, .context = context};
    (void)argp_parse(&argp, count, arguments, ARGP_NO_ERRS | ARGP_NO_HELP | ARGP_NO_EXIT, NULL, &parse);
    if (argument != NULL)
    {
        *argument = parse.argument;
    }
    if (parse.status != 0)
    {
        return parse.status;
    }
    if (command->is_many)
    {
        return parse.arguments > 0 ? 0 : sim_usage("%s: at least one %s is expected", command->name, command->noun);
    }
    if (command->argument == NULL)
    {
        return parse.arguments == 0 ? 0 : sim_usage("%s: unknown argument %s", command->name, parse.argument);
    }
    return parse.arguments == 1
               ? 0
               : sim_usage("%s: one %s is expected, not %d", command->name, command->noun, parse.arguments);
}

int sim_option_word(const sim_command_t *command, int key, const char *value)
{
    const struct argp_option *option = command->options;
    while (option->key != key)
    {
        option++;
    }
    char   listed[128] = "";
    size_t length      = 0;
    int    index       = 0;
    for (const char *word = option->arg; *word != '\0'; index++)
    {
        const size_t size = strcspn(word, "|");
        if (strncmp(word, value, size) == 0 && value[size] == '\0')
        {
            return index;
        }
        length +=
            (size_t)snprintf(listed + length, sizeof listed - length, "%s%.*s", index > 0 ? ", " : "", (int)size, word);
        word += size + (word[size] == '|' ? 1u : 0u);
    }
    (void)sim_usage("--%s %s: must be one of %s", option->name, value, listed);
    return -1;
}

void sim_options_help(const sim_command_t *command)
{
    char name[32];
    (void)snprintf(name, sizeof name, "tribo-sim %s", command->name);
    const struct argp argp = {.options = command->options, .args_doc = command->argument, .doc = command->text};
    argp_help(&argp, stdout, ARGP_HELP_SHORT_USAGE | ARGP_HELP_PRE_DOC | ARGP_HELP_LONG, name);
}
