/// A run of which only its measures are kept: a row of a sweep.

#include "scenario.h"

#include "error.h"
#include "scenario/keys.h"
#include "scenario/runner.h"
#include "scope.h"
#include "support/number.h"

#include <string.h>
#include <time.h>

#define TICKS_A_LOOK 1024u ///< between two looks at the clock

const char *native_number(const char *text, double *value)
{
    return common_number_parse(text, value);
}

const char *native_scenario_number(const native_scenario_t *scenario, const char *key, double *value)
{
    common_place_t place;
    void *const    values = (void *)common_scenario_values(scenario->scenario);
    if (!common_key_find(sim_keys, values, key, &place) || place.at == NULL || place.is_element)
    {
        return NULL;
    }
    common_optional_t given = {.is_given = true};
    switch (place.key->type)
    {
    case COMMON_KEY_OPTIONAL:
        memcpy(&given, place.at, sizeof given);
        break;
    case COMMON_KEY_NUMBER:
        memcpy(&given.value, place.at, sizeof given.value);
        break;
    case COMMON_KEY_WHOLE:
        return "whole";
    default:
        return "other";
    }
    *value = given.value;
    return given.is_given ? "number" : "unset";
}

char *native_scenario_reference(const native_scenario_t *scenario)
{
    const common_reference_config_t *reference = &common_scenario_loop(scenario->scenario)->reference;
    const bool                       is_read   = reference->kind == COMMON_REFERENCE_CSV && reference->file[0] != '\0';
    return is_read ? common_scenario_reference_path(scenario->scenario) : NULL;
}

typedef struct
{
    double   end_s; ///< of this thread's processor time
    unsigned ticks;
    bool     is_late;
} watch_t;

static double processor_s(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static bool watch(void *context, const sim_row_t *row, double part_done, common_error_t *error)
{
    watch_t *const of = context;
    (void)row;
    (void)part_done;
    if (++of->ticks % TICKS_A_LOOK == 0 && processor_s() > of->end_s)
    {
        of->is_late = true;
        return common_error_set(error, "took more processor time than timeout_s");
    }
    return true;
}

const char *native_measure(const native_scenario_t *scenario,
                           bool                     q31,
                           double                   timeout_s,
                           char                   **json,
                           double                  *window_ticks,
                           native_error_t          *error)
{
    const sim_run_options_t options = {.q31 = q31};
    watch_t                 of      = {.end_s = processor_s() + timeout_s};
    common_error_t          said    = {""};
    sim_summary_t           summary;
    const native_scope_t    scope = native_enter();
    *json                         = NULL;
    if (sim_run(scenario->scenario, &options, watch, &of, &summary, &said) &&
        sim_run_was_controlled(scenario->scenario, &summary, &said))
    {
        *json         = sim_summary_to_json(&summary);
        *window_ticks = (double)summary.result.activity.ticks;
    }
    native_leave(&scope);
    if (*json != NULL)
    {
        return "ok";
    }
    native_error_say(error, "", said.text[0] != '\0' ? said.text : "out of memory");
    return of.is_late ? "timeout" : summary.ticks == 0 ? "refused" : "failed";
}
