#include "loop/scenario.h"

#include "keys/reader.h"
#include "keys/suggest.h"
#include "support/file.h"
#include "support/text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct common_scenario
{
    const common_key_t *keys;
    void               *values; ///< a struct that begins with a common_loop_keys_t
    common_sources_t    sources;
    char               *path; ///< path of the file; null if there is none
};

common_scenario_t *common_scenario_create_of(const common_key_t *keys, size_t size)
{
    common_scenario_t *scenario = calloc(1, sizeof *scenario);
    void              *values   = calloc(1, size);
    if (scenario == NULL || values == NULL)
    {
        free(scenario);
        free(values);
        return NULL;
    }
    scenario->keys   = keys;
    scenario->values = values;
    common_key_set_defaults(keys, values);
    return scenario;
}

void common_scenario_destroy(common_scenario_t *scenario)
{
    if (scenario != NULL)
    {
        common_sources_free(&scenario->sources);
        free(scenario->path);
        free(scenario->values);
        free(scenario);
    }
}

const common_key_t *common_scenario_keys(const common_scenario_t *scenario)
{
    return scenario->keys;
}

const void *common_scenario_values(const common_scenario_t *scenario)
{
    return scenario->values;
}

const common_loop_keys_t *common_scenario_loop(const common_scenario_t *scenario)
{
    return scenario->values;
}

/// Takes the keys of the group `prefix` from text; all keys if `prefix` is "".
static bool load_text(common_scenario_t *scenario,
                      const char        *text,
                      const char        *name,
                      const char        *prefix,
                      common_error_t    *error)
{
    common_place_t place = {.key = NULL, .at = scenario->values};
    const bool     whole = prefix[0] == '\0' || !common_key_find(scenario->keys, scenario->values, prefix, &place);
    return common_read(&(common_text_t){.text   = text,
                                        .name   = name,
                                        .prefix = prefix,
                                        .root   = scenario->keys,
                                        .keys   = whole ? scenario->keys : common_key_below(place.key),
                                        .group  = place.at},
                       &scenario->sources,
                       error);
}

static bool load_file(common_scenario_t *scenario, const char *path, const char *prefix, common_error_t *error)
{
    char *text = common_file_read(path, COMMON_FILE_BYTES_MAX, error);
    free(scenario->path);
    scenario->path = strdup(path);
    const bool ok  = text != NULL && scenario->path != NULL && load_text(scenario, text, path, prefix, error);
    free(text);
    return ok;
}

bool common_scenario_load(common_scenario_t *scenario, const char *path, common_error_t *error)
{
    return load_file(scenario, path, "", error);
}

bool common_scenario_load_compensator(common_scenario_t *scenario, const char *path, common_error_t *error)
{
    return load_file(scenario, path, "compensator", error);
}

bool common_scenario_load_text(common_scenario_t *scenario, const char *text, const char *name, common_error_t *error)
{
    return load_text(scenario, text, name, "", error);
}

// --- set -----------------------------------------------------------------------------------------------------------

/// Reads "last part of the key: value" as a mapping that may contain only that key. `name` is the option, for messages.
static bool set_one(common_scenario_t    *scenario,
                    const common_place_t *place,
                    const char           *key,
                    const char           *value,
                    const char           *name,
                    common_error_t       *error)
{
    char        prefix[COMMON_KEY_MAX];
    const char *dot = strrchr(key, '.');
    (void)snprintf(prefix, sizeof prefix, "%.*s", dot != NULL ? (int)(dot - key) : 0, key);
    char *text = common_text_format("%s: %s", place->key->name, value);
    if (text == NULL)
    {
        return common_error_set(error, "out of memory");
    }
    const bool ok = common_read(&(common_text_t){.text      = text,
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

/// Carries out the assignment "key=value", which messages show as `name`.
static bool set(common_scenario_t *scenario, const char *assignment, const char *name, common_error_t *error)
{
    const size_t length = strcspn(assignment, "=");
    if (length == 0 || assignment[length] == '\0')
    {
        return common_error_set(error, "%s: key=value is expected", name);
    }
    char           key[COMMON_KEY_MAX];
    char           suggestion[COMMON_KEY_MAX];
    common_place_t place;
    const bool     fits = snprintf(key, sizeof key, "%.*s", (int)length, assignment) < (int)sizeof key;
    if (!fits || !common_key_find(scenario->keys, scenario->values, key, &place))
    {
        return fits && common_suggest(scenario->keys, key, suggestion)
                   ? common_error_set(error, "%s: unknown key %s, did you mean %s?", name, key, suggestion)
                   : common_error_set(error, "%s: unknown key %.*s", name, (int)length, assignment);
    }
    if (place.is_element)
    {
        return common_error_set(error, "%s: %s is a whole element: set one of its keys, or the list", name, key);
    }
    if (place.at == NULL)
    {
        return common_error_set(error,
                                "%s: the list %.*s has %u elements, counted from 0",
                                name,
                                (int)strcspn(key, "["),
                                key,
                                place.count);
    }
    return set_one(scenario, &place, key, assignment + length + 1, name, error);
}

bool common_scenario_set(common_scenario_t *scenario, const char *assignment, common_error_t *error)
{
    // The start is enough of a value that is longer than any message.
    const int shown = 1000;
    char *name = common_text_format("--set %.*s%s", shown, assignment, strlen(assignment) > (size_t)shown ? "..." : "");
    const bool ok = name != NULL ? set(scenario, assignment, name, error) : common_error_set(error, "out of memory");
    free(name);
    return ok;
}

// --- sources of the keys -------------------------------------------------------------------------------------------

const char *common_scenario_source(const common_scenario_t *scenario, const char *key)
{
    const common_source_t *source = common_sources_find(&scenario->sources, key);
    return source != NULL ? source->place : scenario->path != NULL ? scenario->path : "default";
}

bool common_scenario_has(const common_scenario_t *scenario, const char *key)
{
    return common_sources_has(&scenario->sources, key);
}

bool common_scenario_has_part(const common_scenario_t *scenario, const char *key)
{
    return common_sources_has_part(&scenario->sources, key);
}

bool common_scenario_is_set(const common_scenario_t *scenario, const char *key)
{
    const common_source_t *source = common_sources_find(&scenario->sources, key);
    return source != NULL && source->is_option;
}

char *common_scenario_reference_path(const common_scenario_t *scenario)
{
    const char *file  = common_scenario_loop(scenario)->reference.file;
    const char *slash = (scenario->path != NULL) ? strrchr(scenario->path, '/') : NULL;
    if (file[0] == '/' || slash == NULL || common_scenario_is_set(scenario, "reference.file"))
    {
        return strdup(file);
    }
    return common_text_format("%.*s%s", (int)(slash - scenario->path) + 1, scenario->path, file);
}
