#include "scenario/config.h"

#include "scenario/check.h"
#include "scenario/load.h"
#include "scenario/scenario_data.h"
#include "scenario/suggest.h"
#include "support/file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const sim_friction_config_t default_friction = {.k_min         = 6.0,
                                                       .k_max         = 20.0,
                                                       .m             = 3.0,
                                                       .v0_n_per_s    = 0.007,
                                                       .breakaway     = {.offset_n = 0.007, .slope = 0.3},
                                                       .set_level     = 0.75,
                                                       .reset_level   = 0.8,
                                                       .pulse_width_s = 0.003,
                                                       .gravity_n     = 0.0};

static const sim_arm_config_t default_arm = {.inertia_n_s2_per_deg = 1.2e-4,
                                             .damping_n_s_per_deg  = 0.0288,
                                             .stiffness_n_per_deg  = 3.84};

static void set_defaults(sim_config_t *config)
{
    *config = (sim_config_t){
        .sample_time_s = 1e-3,
        .reference     = {.kind     = SIM_REFERENCE_TRIANGLE,
                          .low_n    = 0.4,
                          .high_n   = 0.6,
                          .period_s = 20.0,
                          .ramp_s   = 10.0,
                          .from_hz  = 0.05,
                          .to_hz    = 1.0,
                          .sweep_s  = 60.0},
        .plant         = {.model                   = SIM_MODEL_PAPER,
                          .step_s                  = 1e-4,
                          .actuator_pole_rad_per_s = 200.0,
                          .friction                = default_friction,
                          .arm                     = default_arm},
        .sensor        = {.pole_rad_per_s = 55.0, .noise_seed = 1},
        .controller    = {.kind = SIM_CONTROLLER_PAPER},
        .compensator   = {.gain = 0.85, .friction = default_friction, .arm = default_arm},
        .limits        = {.u_min_n = -2.0, .u_max_n = 2.0, .input_max_n = 2.0, .full_scale_n = 2.0},
    };
}

sim_scenario_t *sim_scenario_create(void)
{
    sim_scenario_t *scenario = calloc(1, sizeof *scenario);
    if (scenario == NULL)
    {
        return NULL;
    }
    scenario->config = calloc(1, sizeof *scenario->config);
    if (scenario->config == NULL)
    {
        free(scenario);
        return NULL;
    }
    set_defaults(scenario->config);
    return scenario;
}

void sim_scenario_destroy(sim_scenario_t *scenario)
{
    if (scenario != NULL)
    {
        sim_load_free(scenario->config);
        sim_sources_free(&scenario->sources);
        free(scenario->path);
        free(scenario);
    }
}

sim_config_t *sim_scenario_config(sim_scenario_t *scenario)
{
    return scenario->config;
}

static bool load_file(sim_scenario_t *scenario, const char *path, const sim_load_target_t *target, sim_error_t *error)
{
    size_t length = 0;
    char  *text   = sim_file_read(path, &length, error);
    free(scenario->path);
    scenario->path = strdup(path);
    bool ok        = text != NULL && scenario->path != NULL;
    if (ok)
    {
        const sim_load_text_t from = {.text = text, .name = path};
        ok                         = sim_load_text(&from, target, &scenario->sources, error);
    }
    free(text);
    return ok;
}

bool sim_scenario_load(sim_scenario_t *scenario, const char *path, sim_error_t *error)
{
    const sim_load_target_t target = {.schema = &sim_scenario_schema, .data = scenario->config, .prefix = ""};
    return load_file(scenario, path, &target, error);
}

bool sim_scenario_load_compensator(sim_scenario_t *scenario, const char *path, sim_error_t *error)
{
    const sim_load_target_t target = {.schema = &sim_compensator_schema,
                                      .data   = &scenario->config->compensator,
                                      .prefix = "compensator."};
    return load_file(scenario, path, &target, error);
}

/// The struct that the last key of a --set path is in; null with the error filled in if a list has no such element.
static char *find_parent(const sim_scenario_t *scenario,
                         const sim_place_t    *place,
                         const char           *assignment,
                         sim_error_t          *error)
{
    char *base = (char *)scenario->config;
    if (place->list == NULL)
    {
        return base + place->offset;
    }
    char    *holder = base + place->list_offset;
    char    *elements;
    unsigned count;
    memcpy((void *)&elements, holder + place->list->data_offset, sizeof elements);
    memcpy(&count, holder + place->list->count_offset, sizeof count);
    if (place->index >= count)
    {
        (void)sim_error_set(error,
                            "--set %s: the list %.*s has %u elements, counted from 0",
                            assignment,
                            (int)strcspn(assignment, "["),
                            assignment,
                            count);
        return NULL;
    }
    return elements + place->index * place->list->value.sequence.entry->data_size + place->offset;
}

/// Reads "name: value" as YAML against the schema of that one key.
static bool set_one(sim_scenario_t    *scenario,
                    const char        *assignment,
                    size_t             key_length,
                    const sim_place_t *place,
                    sim_error_t       *error)
{
    char *parent = find_parent(scenario, place, assignment, error);
    if (parent == NULL)
    {
        return false;
    }
    const cyaml_schema_field_t fields[2] = {*place->field, CYAML_FIELD_END};
    cyaml_schema_value_t       one       = *place->parent;
    one.flags                            = CYAML_FLAG_POINTER;
    one.mapping.fields                   = fields;

    const char *value = assignment + key_length + 1;
    char        prefix[SIM_KEY_MAX];
    (void)snprintf(prefix, sizeof prefix, "%.*s", (int)(key_length - strlen(place->field->key)), assignment);
    const size_t size = strlen(assignment) + 16;
    char        *text = malloc(2 * size);
    if (text == NULL)
    {
        return sim_error_set(error, "out of memory");
    }
    char *name = text + size;
    (void)snprintf(text, size, "%s: %s", place->field->key, value);
    (void)snprintf(name, size, "--set %s", assignment);
    const sim_load_text_t   from   = {.text = text, .name = name, .is_option = true};
    const sim_load_target_t target = {.schema = &one, .data = parent, .prefix = prefix};
    const bool              ok     = sim_load_text(&from, &target, &scenario->sources, error);
    free(text);
    return ok;
}

bool sim_scenario_set(sim_scenario_t *scenario, const char *assignment, sim_error_t *error)
{
    const char *equals = strchr(assignment, '=');
    if (equals == NULL || equals == assignment)
    {
        return sim_error_set(error, "--set %s: key=value is wanted", assignment);
    }
    const size_t key_length = (size_t)(equals - assignment);
    char         key[SIM_KEY_MAX];
    sim_place_t  place;
    if (key_length < sizeof key)
    {
        (void)snprintf(key, sizeof key, "%.*s", (int)key_length, assignment);
        const bool found = sim_schema_find(&sim_scenario_schema, key, &place);
        if (found && place.is_element)
        {
            return sim_error_set(error,
                                 "--set %s: %s is a whole element: set one of its keys, or the list",
                                 assignment,
                                 key);
        }
        if (found)
        {
            return set_one(scenario, assignment, key_length, &place, error);
        }
    }
    char suggestion[SIM_KEY_MAX];
    if (key_length < sizeof key && sim_suggest(&sim_scenario_schema, key, suggestion, sizeof suggestion))
    {
        return sim_error_set(error, "--set %s: unknown key %s, did you mean %s?", assignment, key, suggestion);
    }
    return sim_error_set(error, "--set %s: unknown key %.*s", assignment, (int)key_length, assignment);
}

const char *sim_scenario_source(const sim_scenario_t *scenario, const char *key)
{
    const char *place = sim_sources_find(&scenario->sources, key);
    if (place != NULL)
    {
        return place;
    }
    return scenario->path != NULL ? scenario->path : "default";
}

char *sim_scenario_reference_path(const sim_scenario_t *scenario)
{
    const char *file  = scenario->config->reference.file;
    const char *place = sim_sources_find(&scenario->sources, "reference.file");
    const char *slash = (scenario->path != NULL) ? strrchr(scenario->path, '/') : NULL;
    if (file[0] == '/' || slash == NULL || (place != NULL && sim_source_is_set(place)))
    {
        return strdup(file);
    }
    const size_t folder = (size_t)(slash - scenario->path) + 1;
    const size_t size   = folder + strlen(file) + 1;
    char        *path   = malloc(size);
    if (path != NULL)
    {
        (void)snprintf(path, size, "%.*s%s", (int)folder, scenario->path, file);
    }
    return path;
}

bool sim_scenario_check(const sim_scenario_t *scenario, sim_error_t *error)
{
    return sim_check_ranges(scenario, error) && sim_check_together(scenario, error);
}
