#include "scenario.h"

#include "error.h"
#include "loop/loop_check.h"
#include "loop/loop_config.h"
#include "scenario/columns.h"
#include "scenario/keys.h"
#include "scenario/runner.h"
#include "scope.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

native_scenario_t *native_scenario_open(const char *path, native_error_t *error)
{
    common_error_t       said     = {""};
    const native_scope_t scope    = native_enter();
    native_scenario_t   *scenario = calloc(1, sizeof *scenario);
    common_scenario_t   *inner    = sim_scenario_create();
    const bool           is_there = scenario != NULL && inner != NULL;
    const bool           ok =
        is_there ? path == NULL || common_scenario_load(inner, path, &said) : common_error_set(&said, "out of memory");
    native_leave(&scope);
    if (ok)
    {
        scenario->scenario = inner;
        return scenario;
    }
    native_error_say(error, "", said.text);
    common_scenario_destroy(inner);
    free(scenario);
    return NULL;
}

void native_scenario_close(native_scenario_t *scenario)
{
    common_scenario_destroy(scenario->scenario);
    free(scenario);
}

const common_loop_keys_t *native_scenario_loop(const native_scenario_t *scenario)
{
    return common_scenario_loop(scenario->scenario);
}

bool native_scenario_has_loop(const native_scenario_t *scenario, common_error_t *error)
{
    return common_check_has_loop(scenario->scenario, error);
}

bool native_scenario_set(native_scenario_t *scenario, const char *assignment, native_error_t *error)
{
    common_error_t       said  = {""};
    const native_scope_t scope = native_enter();
    const bool           ok    = common_scenario_set(scenario->scenario, assignment, &said);
    native_leave(&scope);
    if (ok)
    {
        return true;
    }
    char key[sizeof error->key];
    (void)snprintf(key, sizeof key, "%.*s", (int)strcspn(assignment, "="), assignment);
    native_error_say(error, key, said.text);
    return false;
}

bool native_scenario_put(native_scenario_t *scenario, const char *key, double value)
{
    common_place_t    place;
    void *const       values      = (void *)common_scenario_values(scenario->scenario);
    common_optional_t given       = {.is_given = true, .value = value};
    bool              is_librarys = false;
    for (unsigned i = 0; i < native_parameter_count() && !is_librarys; i++)
    {
        is_librarys = strcmp(native_parameter(i).key, key) == 0;
    }
    if (!is_librarys || !common_key_find(sim_keys, values, key, &place))
    {
        return false;
    }
    const bool is_optional = place.key->type == COMMON_KEY_OPTIONAL;
    if (!is_optional && place.key->type != COMMON_KEY_NUMBER)
    {
        return false;
    }
    memcpy(place.at, is_optional ? (const void *)&given : &value, is_optional ? sizeof given : sizeof value);
    return true;
}

typedef struct
{
    unsigned      left;
    native_key_t *key;
    bool          is_found;
} search_t;

_Static_assert(COMMON_KEY_MAX <= sizeof((native_key_t *)0)->path, "native.h says how long a key is");
_Static_assert(COMMON_WORDS_MAX <= sizeof((native_key_t *)0)->words, "native.h says how long its words are");

static void search(void *context, const char *path, const common_key_t *key)
{
    static const char *const types[] = {[COMMON_KEY_NUMBER]   = "number",
                                        [COMMON_KEY_OPTIONAL] = "number",
                                        [COMMON_KEY_WHOLE]    = "whole",
                                        [COMMON_KEY_CHOICE]   = "choice",
                                        [COMMON_KEY_TEXT]     = "text",
                                        [COMMON_KEY_GROUP]    = "group",
                                        [COMMON_KEY_LIST]     = "list",
                                        [COMMON_KEY_SKIPPED]  = "text"};
    search_t *const          of      = context;
    if (!of->is_found && of->left-- == 0)
    {
        of->is_found  = true;
        of->key->type = types[key->type];
        (void)snprintf(of->key->path, sizeof of->key->path, "%s", path);
        if (key->type == COMMON_KEY_CHOICE)
        {
            common_key_words(key, of->key->words, sizeof of->key->words);
        }
    }
}

bool native_key(unsigned index, native_key_t *key)
{
    search_t of   = {.left = index, .key = key};
    key->words[0] = '\0';
    common_key_visit(sim_keys, search, &of);
    return of.is_found;
}

/// The words are the library's if its set-up refuses the loop with them.
static void say_check(const native_scenario_t *scenario, const common_error_t *said, native_error_t *error)
{
    common_loop_config_t config;
    common_loop_config_fill(&config, native_scenario_loop(scenario));
    const tribo_status_t status = common_loop_config_status(&config);
    native_error_say(error, "", said->text);
    if (status != TRIBO_OK && strstr(said->text, tribo_status_text(status)) != NULL)
    {
        (void)native_accepted(status, error);
    }
}

bool native_scenario_check(native_scenario_t *scenario, native_error_t *error)
{
    common_error_t       said  = {""};
    const native_scope_t scope = native_enter();
    const bool           ok    = sim_scenario_check(scenario->scenario, &said);
    if (!ok)
    {
        say_check(scenario, &said, error);
    }
    native_leave(&scope);
    return ok;
}

size_t native_scenario_ticks(const native_scenario_t *scenario)
{
    const sim_config_t *config = sim_scenario_config(scenario->scenario);
    return (size_t)round(config->duration_s / config->loop.sample_time_s);
}

unsigned native_scenario_columns(const native_scenario_t *scenario)
{
    return sim_column_count(sim_run_learns(sim_scenario_config(scenario->scenario)));
}

const char *native_column_name(unsigned column)
{
    return sim_columns[column].name;
}

bool native_column_is_flag(unsigned column)
{
    return sim_columns[column].is_flag;
}

typedef struct
{
    size_t  rows, every, tick;
    double *trace, *trace_q31;
    bool (*go_on)(void);
} recorder_t;

#define TICKS_BETWEEN_QUESTIONS 65536u // a tenth of a second

static void keep(const recorder_t *recorder, const sim_row_t *row, double *trace)
{
    double         values[SIM_COLUMNS_MAX];
    const unsigned count = sim_column_values(row, values);
    for (unsigned i = 0; i < count; i++)
    {
        trace[i * recorder->rows + recorder->tick / recorder->every] = values[i];
    }
}

static bool record(void *context, const sim_row_t *row, double part_done, common_error_t *error)
{
    recorder_t *const recorder = context;
    (void)part_done;
    if (recorder->tick % TICKS_BETWEEN_QUESTIONS == 0u && !recorder->go_on())
    {
        return common_error_set(error, "interrupted");
    }
    if (recorder->tick % recorder->every == 0u)
    {
        keep(recorder, row, recorder->trace);
        if (row->q31 != NULL)
        {
            keep(recorder, row->q31, recorder->trace_q31);
        }
    }
    recorder->tick++;
    return true;
}

char *native_run(const native_scenario_t *scenario,
                 bool                     q31,
                 size_t                   rows,
                 size_t                   every,
                 double                  *trace,
                 double                  *trace_q31,
                 bool (*go_on)(void),
                 native_error_t *error)
{
    recorder_t recorder = {.rows = rows, .every = every, .trace = trace, .trace_q31 = trace_q31, .go_on = go_on};
    const sim_run_options_t options = {.q31 = q31, .both = trace_q31 != NULL};
    common_error_t          said    = {""};
    sim_summary_t           summary;
    char                   *json  = NULL;
    const native_scope_t    scope = native_enter();
    if (sim_run(scenario->scenario, &options, record, &recorder, &summary, &said) &&
        sim_run_was_controlled(scenario->scenario, &summary, &said))
    {
        json = sim_summary_to_json(&summary);
    }
    native_leave(&scope);
    if (json == NULL)
    {
        native_error_say(error, "", said.text[0] != '\0' ? said.text : "out of memory");
    }
    return json;
}

void native_free(char *text)
{
    free(text);
}
