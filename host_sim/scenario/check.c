#include "scenario/check.h"

#include "scenario/loop_config.h"
#include "scenario/scenario_data.h"
#include "scenario/schema.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static bool complain(const sim_scenario_t *scenario, const char *key, const char *what, sim_error_t *error)
{
    return sim_error_set(error, "%s: %s: %s", sim_scenario_source(scenario, key), key, what);
}

static bool check_number(const sim_scenario_t *scenario, const char *key, double value, sim_error_t *error)
{
    const sim_range_t *range = sim_range_find(key);
    if (range == NULL)
    {
        return complain(scenario, key, "has no range in schema.c", error);
    }
    if (value >= range->min && value <= range->max)
    {
        return true;
    }
    char text[128];
    (void)snprintf(text, sizeof text, "%.10g is outside %g to %g", value, range->min, range->max);
    return complain(scenario, key, text, error);
}

static bool check_mapping(const sim_scenario_t       *scenario,
                          const cyaml_schema_value_t *mapping,
                          const char                 *path,
                          const char                 *data,
                          sim_error_t                *error);

static bool check_list(const sim_scenario_t       *scenario,
                       const cyaml_schema_field_t *field,
                       const char                 *key,
                       const char                 *data,
                       sim_error_t                *error)
{
    const cyaml_schema_value_t *entry = field->value.sequence.entry;
    const char                 *elements;
    unsigned                    count;
    memcpy((void *)&elements, data + field->data_offset, sizeof elements);
    memcpy(&count, data + field->count_offset, sizeof count);
    bool ok = true;
    for (unsigned i = 0; ok && i < count; i++)
    {
        char path[SIM_KEY_MAX];
        (void)snprintf(path, sizeof path, "%.100s[%u]", key, i);
        ok = check_mapping(scenario, entry, path, elements + (size_t)i * entry->data_size, error);
    }
    return ok;
}

static bool check_float(const sim_scenario_t       *scenario,
                        const cyaml_schema_field_t *field,
                        const char                 *key,
                        const char                 *data,
                        sim_error_t                *error)
{
    const char *at = data + field->data_offset;
    if ((field->value.flags & CYAML_FLAG_POINTER) != 0)
    {
        memcpy((void *)&at, data + field->data_offset, sizeof at);
    }
    double value;
    if (at == NULL)
    {
        return true;
    }
    memcpy(&value, at, sizeof value);
    // Required keys have no default; their absence is found, and better said, in sim_check_together.
    return (strcmp(key, "duration_s") == 0 && value == 0.0 && !sim_sources_has(&scenario->sources, key)) ||
           check_number(scenario, key, value, error);
}

static bool check_mapping(const sim_scenario_t       *scenario,
                          const cyaml_schema_value_t *mapping,
                          const char                 *path,
                          const char                 *data,
                          sim_error_t                *error)
{
    bool ok = true;
    for (const cyaml_schema_field_t *field = mapping->mapping.fields; ok && field->key != NULL; field++)
    {
        char key[SIM_KEY_MAX];
        (void)snprintf(key, sizeof key, "%s%s%s", path, path[0] != '\0' ? "." : "", field->key);
        switch (field->value.type)
        {
        case CYAML_MAPPING:
            ok = check_mapping(scenario, &field->value, key, data + field->data_offset, error);
            break;
        case CYAML_SEQUENCE:
            ok = check_list(scenario, field, key, data, error);
            break;
        case CYAML_FLOAT:
            ok = check_float(scenario, field, key, data, error);
            break;
        default:
            break;
        }
    }
    return ok;
}

bool sim_check_ranges(const sim_scenario_t *scenario, sim_error_t *error)
{
    return check_mapping(scenario, &sim_scenario_schema, "", (const char *)scenario->config, error);
}

static bool check_present(const sim_scenario_t *scenario, sim_error_t *error)
{
    const sim_config_t *config = scenario->config;
    if (!(config->duration_s > 0.0))
    {
        return complain(scenario, "duration_s", "is missing", error);
    }
    if (!sim_sources_has(&scenario->sources, "reference.kind"))
    {
        return complain(scenario, "reference.kind", "is missing", error);
    }
    if (config->reference.kind == SIM_REFERENCE_CSV && config->reference.file == NULL)
    {
        return complain(scenario, "reference.file", "is missing, reference.kind is csv", error);
    }
    return true;
}

static bool check_times(const sim_scenario_t *scenario, sim_error_t *error)
{
    const sim_config_t *config = scenario->config;
    const double        ticks  = round(config->duration_s / config->sample_time_s);
    if (ticks < 1.0)
    {
        return complain(scenario, "duration_s", "is shorter than one sample", error);
    }
    const double steps = config->sample_time_s / config->plant.step_s;
    if (fabs(steps - round(steps)) > 1e-6 * steps)
    {
        return complain(scenario, "plant.step_s", "must go into sample_time_s a whole number of times", error);
    }
    const double end = (config->metrics.end_s != NULL) ? *config->metrics.end_s : config->duration_s;
    if (end > config->duration_s)
    {
        return complain(scenario, "metrics.end_s", "is after the end of the run", error);
    }
    if (!(config->metrics.start_s < end))
    {
        return complain(scenario, "metrics.start_s", "leaves no time before the window's end", error);
    }
    return true;
}

static bool check_friction(const sim_scenario_t        *scenario,
                           const sim_friction_config_t *friction,
                           const char                  *whose,
                           sim_error_t                 *error)
{
    char key[SIM_KEY_MAX];
    if (friction->k_min > friction->k_max)
    {
        (void)snprintf(key, sizeof key, "%s.friction.k_min", whose);
        return complain(scenario, key, "is larger than k_max", error);
    }
    const sim_breakaway_point_t *points = friction->breakaway.table;
    if (points == NULL)
    {
        return true;
    }
    static const char *const law[] = {"offset_N", "slope", "negative_offset_N", "negative_slope"};
    char                     table[SIM_KEY_MAX];
    (void)snprintf(table, sizeof table, "%s.friction.breakaway.table", whose);
    for (size_t i = 0; i < sizeof law / sizeof law[0]; i++)
    {
        (void)snprintf(key, sizeof key, "%s.friction.breakaway.%s", whose, law[i]);
        // A table of --set goes over a file's law.
        if (sim_sources_has(&scenario->sources, key) && (sim_source_is_set(sim_scenario_source(scenario, key)) ||
                                                         !sim_source_is_set(sim_scenario_source(scenario, table))))
        {
            return complain(scenario, key, "does not go with a table, which is in its place", error);
        }
    }
    for (unsigned i = 1; i < friction->breakaway.table_count; i++)
    {
        if (!(points[i].force_n > points[i - 1].force_n))
        {
            (void)snprintf(key, sizeof key, "%s.friction.breakaway.table[%u].force_N", whose, i);
            return complain(scenario, key, "must be larger than in the point before", error);
        }
    }
    return true;
}

static bool check_controller(const sim_scenario_t *scenario, sim_error_t *error)
{
    const sim_config_t *config = scenario->config;
    const bool          paper  = config->controller.kind == SIM_CONTROLLER_PAPER;
    if (paper && config->controller.sections != NULL)
    {
        return complain(scenario, "controller.sections", "go with controller.kind z or delta, not with paper", error);
    }
    if (!paper && config->controller.sections == NULL)
    {
        return complain(scenario, "controller.sections", "is missing, controller.kind is not paper", error);
    }
    if (paper && fabs(config->sample_time_s - 1e-3) > 1e-9)
    {
        return complain(scenario, "sample_time_s", "must be 0.001 with controller.kind paper", error);
    }
    return true;
}

/// The key that a status of the library is about.
static const char *status_key(tribo_status_t status)
{
    static const struct
    {
        tribo_status_t status;
        const char    *key;
    } keys[] = {
        {TRIBO_ERR_SAMPLE_TIME, "sample_time_s"},
        {TRIBO_ERR_K_MIN, "compensator.friction.k_min"},
        {TRIBO_ERR_K_MAX, "compensator.friction.k_max"},
        {TRIBO_ERR_M, "compensator.friction.m"},
        {TRIBO_ERR_V0, "compensator.friction.v0_N_per_s"},
        {TRIBO_ERR_BREAKAWAY_OFFSET, "compensator.friction.breakaway.offset_N"},
        {TRIBO_ERR_BREAKAWAY_SLOPE, "compensator.friction.breakaway.slope"},
        {TRIBO_ERR_TABLE_LENGTH, "compensator.friction.breakaway.table"},
        {TRIBO_ERR_TABLE_FORCE, "compensator.friction.breakaway.table"},
        {TRIBO_ERR_TABLE_BREAKAWAY, "compensator.friction.breakaway.table"},
        {TRIBO_ERR_SET_LEVEL, "compensator.friction.set_level"},
        {TRIBO_ERR_RESET_LEVEL, "compensator.friction.reset_level"},
        {TRIBO_ERR_PULSE_WIDTH, "compensator.friction.pulse_width_s"},
        {TRIBO_ERR_GRAVITY, "compensator.friction.gravity_N"},
        {TRIBO_ERR_INERTIA, "compensator.arm.inertia_N_s2_per_deg"},
        {TRIBO_ERR_DAMPING, "compensator.arm.damping_N_s_per_deg"},
        {TRIBO_ERR_STIFFNESS, "compensator.arm.stiffness_N_per_deg"},
        {TRIBO_ERR_ARM_TOO_FAST, "compensator.arm"},
        {TRIBO_ERR_SECTION_COUNT, "controller.sections"},
        {TRIBO_ERR_SECTION_COEFFICIENT, "controller.sections"},
        {TRIBO_ERR_SECTION_FEEDTHROUGH, "controller.sections"},
        {TRIBO_ERR_SECTION_UNSTABLE, "controller.sections"},
        {TRIBO_ERR_ANTI_WINDUP, "controller.sections"},
        {TRIBO_ERR_U_MIN, "limits.u_min_N"},
        {TRIBO_ERR_U_MAX, "limits.u_max_N"},
        {TRIBO_ERR_GAIN, "compensator.gain"},
        {TRIBO_ERR_INPUT_MAX, "limits.input_max_N"},
        {TRIBO_ERR_FULL_SCALE, "limits.full_scale_N"},
        {TRIBO_ERR_HEADROOM, "controller.sections"},
    };

    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++)
    {
        if (keys[i].status == status)
        {
            return keys[i].key;
        }
    }
    return "scenario";
}

/// The value of a key that is a number in its own right.
static bool find_number(const sim_scenario_t *scenario, const char *key, double *value)
{
    sim_place_t place;
    if (!sim_schema_find(&sim_scenario_schema, key, &place) || place.field->value.type != CYAML_FLOAT ||
        (place.field->value.flags & CYAML_FLAG_POINTER) != 0)
    {
        return false;
    }
    memcpy(value, (const char *)scenario->config + place.offset + place.field->data_offset, sizeof *value);
    return true;
}

/// The key of the first section that alone is refused with `status`; false if there is none.
static bool find_section(const sim_scenario_t *scenario, tribo_status_t status, char *key, size_t size)
{
    sim_loop_config_t             loop;
    tribo_controller_f32_params_t params;
    sim_loop_config_fill(&loop, scenario->config);
    for (unsigned i = 0; i < scenario->config->controller.sections_count; i++)
    {
        const tribo_controller_f32_config_t one = {.sections      = &loop.sections[i],
                                                   .section_count = 1,
                                                   .u_min_n       = -1.0f,
                                                   .u_max_n       = 1.0f};
        if (tribo_controller_f32_init(&params, &one) == status)
        {
            (void)snprintf(key, size, "controller.sections[%u]", i);
            return true;
        }
    }
    return false;
}

bool sim_check_status(const sim_scenario_t *scenario, tribo_status_t status, sim_error_t *error)
{
    if (status == TRIBO_OK)
    {
        return true;
    }
    const sim_breakaway_config_t *law  = &scenario->config->compensator.friction.breakaway;
    const char                   *key  = status_key(status);
    const char                   *text = tribo_status_text(status);
    char                          section[SIM_KEY_MAX];
    char                          with_value[256];
    double                        value;
    if ((status == TRIBO_ERR_BREAKAWAY_OFFSET && law->negative_offset_n != NULL) ||
        (status == TRIBO_ERR_BREAKAWAY_SLOPE && law->negative_slope != NULL))
    {
        key = "compensator.friction.breakaway"; // of either direction
    }
    else if (strcmp(key, "controller.sections") == 0 && find_section(scenario, status, section, sizeof section))
    {
        key = section;
    }
    if (find_number(scenario, key, &value))
    {
        (void)snprintf(with_value, sizeof with_value, "%.10g is refused: %s", value, text);
        text = with_value;
    }
    return complain(scenario, key, text, error);
}

bool sim_check_compensator(const sim_scenario_t *scenario, sim_error_t *error)
{
    return check_friction(scenario, &scenario->config->compensator.friction, "compensator", error);
}

bool sim_check_together(const sim_scenario_t *scenario, sim_error_t *error)
{
    const sim_config_t *config = scenario->config;
    if (!(check_present(scenario, error) && check_times(scenario, error) &&
          check_friction(scenario, &config->plant.friction, "plant", error) && sim_check_compensator(scenario, error) &&
          check_controller(scenario, error)))
    {
        return false;
    }
    sim_loop_config_t             loop;
    tribo_force_loop_f32_params_t params;
    sim_loop_config_fill(&loop, config);
    return sim_check_status(scenario, tribo_force_loop_f32_init(&params, &loop.config), error);
}
