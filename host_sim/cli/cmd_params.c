#include "cli/commands.h"
#include "cli/params_header.h"
#include "cli/scenario_folder.h"
#include "scenario/check.h"
#include "scenario/loop_config.h"
#include "support/file.h"
#include "support/output_file.h"

#include <ctype.h>
#include <getopt.h>
#include <stdlib.h>
#include <string.h>

#define NAME_MAX_LENGTH 40u

typedef struct
{
    sim_scenario_choice_t choice;
    bool                  q31;
    const char           *out;                       ///< null: standard output
    char                  name[NAME_MAX_LENGTH + 1]; ///< empty: the scenario's
} options_t;

/// A C identifier that is nobody's keyword once something is appended, nor reserved.
static bool take_name(options_t *options, const char *name, size_t length)
{
    if (length == 0 || length > NAME_MAX_LENGTH || !isalpha((unsigned char)name[0]))
    {
        return false;
    }
    for (size_t i = 0; i < length; i++)
    {
        if (!isalnum((unsigned char)name[i]) && name[i] != '_')
        {
            return false;
        }
        options->name[i] = name[i];
    }
    options->name[length] = '\0';
    return true;
}

static const char *file_name(const sim_scenario_choice_t *choice)
{
    const char *slash = strrchr(choice->name, '/');
    return slash != NULL ? slash + 1 : choice->name;
}

/// The scenario's file name without its ending.
static bool take_name_of_scenario(options_t *options)
{
    const char  *base   = file_name(&options->choice);
    const size_t length = strlen(base);
    const bool   yaml   = length > 5 && strcmp(base + length - 5, ".yaml") == 0;
    return take_name(options, base, yaml ? length - 5 : length);
}

/// Takes the command line; 0, or the status to exit with.
static int take_options(options_t *options, int count, char **arguments)
{
    static const struct option known[] = {{"set", required_argument, NULL, 's'},
                                          {"out", required_argument, NULL, 'o'},
                                          {"arith", required_argument, NULL, 'a'},
                                          {"name", required_argument, NULL, 'n'},
                                          {NULL, 0, NULL, 0}};

    opterr = 0;
    int letter;
    int status;
    while ((letter = getopt_long(count, arguments, ":", known, NULL)) != -1)
    {
        switch (letter)
        {
        case 's':
            status = sim_scenario_take_set(&options->choice, optarg);
            if (status != 0)
            {
                return status;
            }
            break;
        case 'o':
            options->out = optarg;
            break;
        case 'a':
            options->q31 = strcmp(optarg, "q31") == 0;
            if (!options->q31 && strcmp(optarg, "f32") != 0)
            {
                return sim_usage("--arith %s: there are f32, q31", optarg);
            }
            break;
        case 'n':
            if (!take_name(options, optarg, strlen(optarg)))
            {
                return sim_usage("--name %s: up to %u letters, digits and _, a letter first", optarg, NAME_MAX_LENGTH);
            }
            break;
        case ':':
            return sim_usage("params: %s wants a value", arguments[optind - 1]);
        default:
            return sim_usage("params: unknown option %s", arguments[optind - 1]);
        }
    }
    if (optind + 1 != count)
    {
        return sim_usage("params: one scenario is wanted, not %d", count - optind);
    }
    options->choice.name = arguments[optind];
    if (options->name[0] == '\0' && !take_name_of_scenario(options))
    {
        return sim_usage("params: %s is no name in C: one is wanted with --name", options->choice.name);
    }
    return 0;
}

/// A scenario is not to be overwritten by what is made of it.
static int check_out(const options_t *options)
{
    char *path   = sim_scenario_path(options->choice.name);
    int   status = 0;
    if (options->out != NULL && path != NULL && sim_file_is_same(options->out, path))
    {
        status = sim_usage("params: --out %s is the same file as the scenario %s", options->out, path);
    }
    free(path);
    return status;
}

static bool write_header(const options_t *options, const sim_params_header_t *header, sim_error_t *error)
{
    sim_output_file_t file;
    if (!sim_output_file_open(&file, options->out, error))
    {
        return false;
    }
    sim_params_header_write(file.stream, header);
    return sim_output_file_commit(&file, error);
}

static bool make(const options_t *options, sim_scenario_t *scenario, sim_error_t *error)
{
    if (!sim_scenario_open(scenario, &options->choice, error))
    {
        return false;
    }
    const sim_config_t *config = sim_scenario_config(scenario);
    sim_loop_config_t   loop_config;
    sim_loop_t          loop;
    sim_loop_config_fill(&loop_config, config);
    const tribo_status_t status = sim_loop_init(&loop, options->q31, &loop_config.config, config->limits.full_scale_n);
    return sim_check_status(scenario, status, error) &&
           write_header(options,
                        &(sim_params_header_t){.name      = options->name,
                                               .scenario  = file_name(&options->choice),
                                               .sets      = options->choice.sets,
                                               .set_count = options->choice.set_count,
                                               .config    = &loop_config.config,
                                               .loop      = &loop},
                        error);
}

int sim_command_params(int count, char **arguments)
{
    options_t options = {.choice = {.name = "", .sets = (char **)calloc((size_t)count, sizeof(char *))}};
    if (options.choice.sets == NULL)
    {
        return sim_failure("out of memory");
    }
    int status = take_options(&options, count, arguments);
    if (status == 0)
    {
        status = check_out(&options);
    }
    if (status == 0)
    {
        sim_error_t     error    = {""};
        sim_scenario_t *scenario = sim_scenario_create();
        const bool ok = scenario != NULL ? make(&options, scenario, &error) : sim_error_set(&error, "out of memory");
        sim_scenario_destroy(scenario);
        status = ok ? SIM_EXIT_OK : sim_failure(error.text);
    }
    free((void *)options.choice.sets);
    return status;
}
