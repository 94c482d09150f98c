#include "loop/loop_config.h"
#include "scenario/check.h"
#include "scenario/params_header.h"
#include "sim/commands.h"
#include "sim/scenario_choice.h"
#include "support/file.h"
#include "support/output_file.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NAME_MAX_LENGTH 40u

typedef struct
{
    sim_scenario_choice_t choice;
    int                   arith;                     ///< 0: f32, 1: Q31; negative: as the scenario says
    const char           *out;                       ///< null: standard output
    char                  name[NAME_MAX_LENGTH + 1]; ///< empty: the scenario's
} options_t;

/// Accepts a C identifier that is not reserved and does not become a keyword with a suffix.
static bool take_name(options_t *options, const char *name, size_t length)
{
    static const char allowed[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_";
    if (length > NAME_MAX_LENGTH || !isalpha((unsigned char)name[0]) || strspn(name, allowed) < length)
    {
        return false;
    }
    (void)snprintf(options->name, sizeof options->name, "%.*s", (int)length, name);
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

enum
{
    OPTION_SET = SIM_OPTION_FIRST,
    OPTION_LEARNED,
    OPTION_OUT,
    OPTION_ARITH,
    OPTION_NAME
};

// clang-format off: one row an option
static const struct argp_option known[] = {
    {.name = "arith", .key = OPTION_ARITH, .arg = "f32|q31", .doc = "the loop's arithmetic; the scenario's if left out, f32 in most"},
    {.name = "set", .key = OPTION_SET, .arg = "KEY=VALUE", .doc = "changes any key of the scenario"},
    {.name = "learned", .key = OPTION_LEARNED, .arg = "FILE.yaml", .doc = "starts with the breakaway that a run has learned (its DIR/learned.yaml)"},
    {.name = "name", .key = OPTION_NAME, .arg = "NAME", .doc = "declares NAME_params; the scenario's name if left out"},
    {.name = "out", .key = OPTION_OUT, .arg = "FILE.h", .doc = "the file to write; standard output if left out"},
    {.name = NULL}};
// clang-format on

static int take(void *context, int key, const char *value)
{
    options_t *options = context;
    switch (key)
    {
    case OPTION_SET:
        return sim_scenario_take_set(&options->choice, value);
    case OPTION_LEARNED:
        options->choice.learned = value;
        return 0;
    case OPTION_OUT:
        options->out = value;
        return 0;
    case OPTION_ARITH:
        options->arith = sim_option_word(&sim_command_params, key, value);
        return options->arith >= 0 ? 0 : SIM_EXIT_USAGE;
    default:
        return take_name(options, value, strlen(value))
                   ? 0
                   : sim_usage("--name %s: up to %u letters, digits and _, a letter first", value, NAME_MAX_LENGTH);
    }
}

/// The result must not overwrite its scenario, nor what was learned.
static int check_out(const options_t *options)
{
    char *path   = sim_scenario_path(options->choice.name);
    int   status = 0;
    if (options->out != NULL && path != NULL && common_file_is_same(options->out, path))
    {
        status = sim_usage("params: --out %s is the same file as the scenario %s", options->out, path);
    }
    free(path);
    if (status == 0 && options->out != NULL && options->choice.learned != NULL &&
        common_file_is_same(options->out, options->choice.learned))
    {
        status = sim_usage("params: --out %s is the same file as --learned %s", options->out, options->choice.learned);
    }
    return status;
}

static bool write_header(const options_t *options, const sim_params_header_t *header, common_error_t *error)
{
    common_output_file_t file;
    if (!common_output_open(&file, options->out, error))
    {
        return false;
    }
    (header->loop->q31 ? sim_params_header_q31_write : sim_params_header_f32_write)(file.stream, header);
    return common_output_commit(&file, 1, error);
}

static bool make(const options_t *options, const common_scenario_t *scenario, common_error_t *error)
{
    const sim_config_t  *config = sim_scenario_config(scenario);
    common_loop_config_t loop_config;
    sim_loop_t           loop;
    common_loop_config_fill(&loop_config, &config->loop);
    const bool           q31    = options->arith < 0 ? config->arithmetic == SIM_Q31 : options->arith == 1;
    const tribo_status_t status = sim_loop_init(&loop, q31, &loop_config, config->loop.limits.full_scale_n);
    return common_check_has_loop(scenario, error) && common_check_status(scenario, status, error) &&
           write_header(options,
                        &(sim_params_header_t){.name          = options->name,
                                               .scenario      = file_name(&options->choice),
                                               .description   = config->description,
                                               .sets          = options->choice.sets,
                                               .set_count     = options->choice.set_count,
                                               .config        = &loop_config.parts.config,
                                               .loop          = &loop,
                                               .is_sensorless = loop_config.parts.is_sensorless},
                        error);
}

static int open_and_make(options_t *options)
{
    if (options->name[0] == '\0' && !take_name_of_scenario(options))
    {
        return sim_usage("params: %s is not a name in C: give one with --name", options->choice.name);
    }
    int status = sim_scenario_check_arithmetic(&options->choice, options->arith < 0 ? 1 : 0);
    status     = status == 0 ? check_out(options) : status;
    if (status != 0)
    {
        return status;
    }
    common_error_t     error    = {""};
    common_scenario_t *scenario = sim_scenario_open(&options->choice, &error);
    const bool         ok       = scenario != NULL && make(options, scenario, &error);
    common_scenario_destroy(scenario);
    return ok ? SIM_EXIT_OK : sim_failure(error.text);
}

static int run(int count, char **arguments)
{
    options_t options = {.arith = -1};
    int       status  = sim_options_parse(&sim_command_params, count, arguments, &options, &options.choice.name);
    if (status == 0)
    {
        status = open_and_make(&options);
    }
    sim_scenario_choice_free(&options.choice);
    return status;
}

const sim_command_t sim_command_params = {
    .name     = "params",
    .argument = "SCENARIO.yaml",
    .noun     = "scenario",
    .text     = "Writes the scenario's loop as checked params in C, for firmware without set-up code.",
    .options  = known,
    .run      = run,
    .take     = take};
