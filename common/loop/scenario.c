#include "loop/scenario.h"

#include "keys/reader.h"
#include "keys/suggest.h"
#include "support/file.h"
#include "support/text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct sim_scenario
{
    const sim_key_t *keys;
    void            *values; ///< begin with a sim_loop_keys_t
    sim_sources_t    sources;
    char            *path; ///< of the file; null if there is none
};

sim_scenario_t *sim_scenario_create_of(const sim_key_t *keys, size_t size)
{
    sim_scenario_t *scenario = calloc(1, sizeof *scenario);
    void           *values   = calloc(1, size);
    if (scenario == NULL || values == NULL)
    {
        free(scenario);
        free(values);
        return NULL;
    }
    scenario->keys   = keys;
    scenario->values = values;
    sim_key_set_defaults(keys, values);
    return scenario;
}

void sim_scenario_destroy(sim_scenario_t *scenario)
{
    if (scenario != NULL)
    {
        sim_sources_free(&scenario->sources);
        free(scenario->path);
        free(scenario->values);
        free(scenario);
    }
}

const sim_key_t *sim_scenario_keys(const sim_scenario_t *scenario)
{
    return scenario->keys;
}

const void *sim_scenario_values(const sim_scenario_t *scenario)
{
    return scenario->values;
}

const sim_loop_keys_t *sim_scenario_loop(const sim_scenario_t *scenario)
{
    return scenario->values;
}

/// Takes the keys of the group `prefix` from text, all keys if it is "".
static bool load_text(sim_scenario_t *scenario,
                      const char     *text,
                      const char     *name,
                      const char     *prefix,
                      sim_error_t    *error)
{
    sim_place_t place = {.key = NULL, .at = scenario->values};
    const bool  whole = prefix[0] == '\0' || !sim_key_find(scenario->keys, scenario->values, prefix, &place);
    return sim_read(&(sim_text_t){.text   = text,
                                  .name   = name,
                                  .prefix = prefix,
                                  .root   = scenario->keys,
                                  .keys   = whole ? scenario->keys : sim_key_below(place.key),
                                  .group  = place.at},
                    &scenario->sources,
                    error);
}

static bool load_file(sim_scenario_t *scenario, const char *path, const char *prefix, sim_error_t *error)
{
    char *text = sim_file_read(path, SIM_FILE_BYTES_MAX, error);
    free(scenario->path);
    scenario->path = strdup(path);
    const bool ok  = text != NULL && scenario->path != NULL && load_text(scenario, text, path, prefix, error);
    free(text);
    return ok;
}

bool sim_scenario_load(sim_scenario_t *scenario, const char *path, sim_error_t *error)
{
    return load_file(scenario, path, "", error);
}

bool sim_scenario_load_compensator(sim_scenario_t *scenario, const char *path, sim_error_t *error)
{
    return load_file(scenario, path, "compensator", error);
}

bool sim_scenario_load_text(sim_scenario_t *scenario, const char *text, const char *name, sim_error_t *error)
{
    return load_text(scenario, text, name, "", error);
}

// --- set -----------------------------------------------------------------------------------------------------------

/// Reads "last part of the key: value" as a mapping in which only that key may be. `name` is the option, for messages.
static bool set_one(sim_scenario_t    *scenario,
                    const sim_place_t *place,
                    const char        *key,
                    const char        *value,
                    const char        *name,
                    sim_error_t       *error)
{
    char        prefix[SIM_KEY_MAX];
    const char *dot = strrchr(key, '.');
    (void)snprintf(prefix, sizeof prefix, "%.*s", dot != NULL ? (int)(dot - key) : 0, key);
    char *text = sim_text_format("%s: %s", place->key->name, value);
    if (text == NULL)
    {
        return sim_error_set(error, "out of memory");
    }
    const bool ok = sim_read(&(sim_text_t){.text      = text,
                                           .name      = name,
                                           .is_option = true,
                                           .prefix    = prefix,
                                           .root      = scenario->keys,
                                           .keys      = place->key,
                                           .only      = place->key,
                                           .group     = place->at - place->key->offset},
                             &scenario->sources,
                             error);
    free(text);
    return ok;
}

/// The assignment "key=value", of which `name` is how messages show it.
static bool set(sim_scenario_t *scenario, const char *assignment, const char *name, sim_error_t *error)
{
    const size_t length = strcspn(assignment, "=");
    if (length == 0 || assignment[length] == '\0')
    {
        return sim_error_set(error, "%s: key=value is wanted", name);
    }
    char        key[SIM_KEY_MAX];
    char        suggestion[SIM_KEY_MAX];
    sim_place_t place;
    const bool  fits = snprintf(key, sizeof key, "%.*s", (int)length, assignment) < (int)sizeof key;
    if (!fits || !sim_key_find(scenario->keys, scenario->values, key, &place))
    {
        return fits && sim_suggest(scenario->keys, key, suggestion)
                   ? sim_error_set(error, "%s: unknown key %s, did you mean %s?", name, key, suggestion)
                   : sim_error_set(error, "%s: unknown key %.*s", name, (int)length, assignment);
    }
    if (place.is_element)
    {
        return sim_error_set(error, "%s: %s is a whole element: set one of its keys, or the list", name, key);
    }
    if (place.at == NULL)
    {
        return sim_error_set(error,
                             "%s: the list %.*s has %u elements, counted from 0",
                             name,
                             (int)strcspn(key, "["),
                             key,
                             place.count);
    }
    return set_one(scenario, &place, key, assignment + length + 1, name, error);
}

bool sim_scenario_set(sim_scenario_t *scenario, const char *assignment, sim_error_t *error)
{
    // Of a value that is longer than any message the start tells enough.
    const int shown = 1000;
    char *name    = sim_text_format("--set %.*s%s", shown, assignment, strlen(assignment) > (size_t)shown ? "..." : "");
    const bool ok = name != NULL ? set(scenario, assignment, name, error) : sim_error_set(error, "out of memory");
    free(name);
    return ok;
}

// --- what was written where ----------------------------------------------------------------------------------------

const char *sim_scenario_source(const sim_scenario_t *scenario, const char *key)
{
    const sim_source_t *source = sim_sources_find(&scenario->sources, key);
    return source != NULL ? source->place : scenario->path != NULL ? scenario->path : "default";
}

bool sim_scenario_has(const sim_scenario_t *scenario, const char *key)
{
    return sim_sources_has(&scenario->sources, key);
}

bool sim_scenario_is_set(const sim_scenario_t *scenario, const char *key)
{
    const sim_source_t *source = sim_sources_find(&scenario->sources, key);
    return source != NULL && source->is_option;
}

char *sim_scenario_reference_path(const sim_scenario_t *scenario)
{
    const char *file  = sim_scenario_loop(scenario)->reference.file;
    const char *slash = (scenario->path != NULL) ? strrchr(scenario->path, '/') : NULL;
    if (file[0] == '/' || slash == NULL || sim_scenario_is_set(scenario, "reference.file"))
    {
        return strdup(file);
    }
    return sim_text_format("%.*s%s", (int)(slash - scenario->path) + 1, scenario->path, file);
}
