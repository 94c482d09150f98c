#include "scenario/schema.h"

#include "scenario/config.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define OPTIONAL  CYAML_FLAG_OPTIONAL
#define OWN_VALUE (CYAML_FLAG_OPTIONAL | CYAML_FLAG_POINTER) ///< null when not given
#define CHOICE    (CYAML_FLAG_OPTIONAL | CYAML_FLAG_STRICT)

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

static const cyaml_schema_field_t point_fields[] = {
    CYAML_FIELD_FLOAT("force_N", CYAML_FLAG_DEFAULT, sim_breakaway_point_t, force_n),
    CYAML_FIELD_FLOAT("positive_N", CYAML_FLAG_DEFAULT, sim_breakaway_point_t, positive_n),
    CYAML_FIELD_FLOAT("negative_N", CYAML_FLAG_DEFAULT, sim_breakaway_point_t, negative_n),
    CYAML_FIELD_END};
static const cyaml_schema_value_t point_schema = {
    CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, sim_breakaway_point_t, point_fields)};

static const cyaml_schema_field_t breakaway_fields[] = {
    CYAML_FIELD_FLOAT("offset_N", OPTIONAL, sim_breakaway_config_t, offset_n),
    CYAML_FIELD_FLOAT("slope", OPTIONAL, sim_breakaway_config_t, slope),
    CYAML_FIELD_FLOAT_PTR("negative_offset_N", OWN_VALUE, sim_breakaway_config_t, negative_offset_n),
    CYAML_FIELD_FLOAT_PTR("negative_slope", OWN_VALUE, sim_breakaway_config_t, negative_slope),
    CYAML_FIELD_SEQUENCE("table", OWN_VALUE, sim_breakaway_config_t, table, &point_schema, 1, 32),
    CYAML_FIELD_END};

static const cyaml_schema_field_t friction_fields[] = {
    CYAML_FIELD_FLOAT("k_min", OPTIONAL, sim_friction_config_t, k_min),
    CYAML_FIELD_FLOAT("k_max", OPTIONAL, sim_friction_config_t, k_max),
    CYAML_FIELD_FLOAT("m", OPTIONAL, sim_friction_config_t, m),
    CYAML_FIELD_FLOAT("v0_N_per_s", OPTIONAL, sim_friction_config_t, v0_n_per_s),
    CYAML_FIELD_MAPPING("breakaway", OPTIONAL, sim_friction_config_t, breakaway, breakaway_fields),
    CYAML_FIELD_FLOAT("set_level", OPTIONAL, sim_friction_config_t, set_level),
    CYAML_FIELD_FLOAT("reset_level", OPTIONAL, sim_friction_config_t, reset_level),
    CYAML_FIELD_FLOAT("pulse_width_s", OPTIONAL, sim_friction_config_t, pulse_width_s),
    CYAML_FIELD_FLOAT("gravity_N", OPTIONAL, sim_friction_config_t, gravity_n),
    CYAML_FIELD_END};

static const cyaml_schema_field_t arm_fields[] = {
    CYAML_FIELD_FLOAT("inertia_N_s2_per_deg", OPTIONAL, sim_arm_config_t, inertia_n_s2_per_deg),
    CYAML_FIELD_FLOAT("damping_N_s_per_deg", OPTIONAL, sim_arm_config_t, damping_n_s_per_deg),
    CYAML_FIELD_FLOAT("stiffness_N_per_deg", OPTIONAL, sim_arm_config_t, stiffness_n_per_deg),
    CYAML_FIELD_END};

static const cyaml_strval_t reference_kinds[] = {{"triangle", SIM_REFERENCE_TRIANGLE},
                                                 {"sine", SIM_REFERENCE_SINE},
                                                 {"step", SIM_REFERENCE_STEP},
                                                 {"ramp", SIM_REFERENCE_RAMP},
                                                 {"sawtooth", SIM_REFERENCE_SAWTOOTH},
                                                 {"chirp", SIM_REFERENCE_CHIRP},
                                                 {"csv", SIM_REFERENCE_CSV}};

static const cyaml_schema_field_t reference_fields[] = {
    CYAML_FIELD_ENUM("kind", CHOICE, sim_reference_config_t, kind, reference_kinds, COUNT(reference_kinds)),
    CYAML_FIELD_FLOAT("low_N", OPTIONAL, sim_reference_config_t, low_n),
    CYAML_FIELD_FLOAT("high_N", OPTIONAL, sim_reference_config_t, high_n),
    CYAML_FIELD_FLOAT("start_s", OPTIONAL, sim_reference_config_t, start_s),
    CYAML_FIELD_FLOAT("period_s", OPTIONAL, sim_reference_config_t, period_s),
    CYAML_FIELD_FLOAT("ramp_s", OPTIONAL, sim_reference_config_t, ramp_s),
    CYAML_FIELD_FLOAT("from_Hz", OPTIONAL, sim_reference_config_t, from_hz),
    CYAML_FIELD_FLOAT("to_Hz", OPTIONAL, sim_reference_config_t, to_hz),
    CYAML_FIELD_FLOAT("sweep_s", OPTIONAL, sim_reference_config_t, sweep_s),
    CYAML_FIELD_STRING_PTR("file", OWN_VALUE, sim_reference_config_t, file, 1, 4096),
    CYAML_FIELD_END};

static const cyaml_strval_t models[] = {{"paper", SIM_MODEL_PAPER}};

static const cyaml_schema_field_t plant_fields[] = {
    CYAML_FIELD_ENUM("model", CHOICE, sim_plant_keys_t, model, models, COUNT(models)),
    CYAML_FIELD_FLOAT("step_s", OPTIONAL, sim_plant_keys_t, step_s),
    CYAML_FIELD_FLOAT("actuator_pole_rad_per_s", OPTIONAL, sim_plant_keys_t, actuator_pole_rad_per_s),
    CYAML_FIELD_MAPPING("friction", OPTIONAL, sim_plant_keys_t, friction, friction_fields),
    CYAML_FIELD_MAPPING("arm", OPTIONAL, sim_plant_keys_t, arm, arm_fields),
    CYAML_FIELD_END};

static const cyaml_schema_field_t sensor_fields[] = {
    CYAML_FIELD_FLOAT("pole_rad_per_s", OPTIONAL, sim_sensor_keys_t, pole_rad_per_s),
    CYAML_FIELD_FLOAT("noise_N", OPTIONAL, sim_sensor_keys_t, noise_n),
    CYAML_FIELD_UINT("noise_seed", OPTIONAL, sim_sensor_keys_t, noise_seed),
    CYAML_FIELD_FLOAT("quantisation_N", OPTIONAL, sim_sensor_keys_t, quantisation_n),
    CYAML_FIELD_FLOAT("delay_s", OPTIONAL, sim_sensor_keys_t, delay_s),
    CYAML_FIELD_END};

static const cyaml_schema_field_t section_fields[] = {CYAML_FIELD_FLOAT("b0", CYAML_FLAG_DEFAULT, sim_section_t, b0),
                                                      CYAML_FIELD_FLOAT("b1", CYAML_FLAG_DEFAULT, sim_section_t, b1),
                                                      CYAML_FIELD_FLOAT("b2", CYAML_FLAG_DEFAULT, sim_section_t, b2),
                                                      CYAML_FIELD_FLOAT("a1", CYAML_FLAG_DEFAULT, sim_section_t, a1),
                                                      CYAML_FIELD_FLOAT("a2", CYAML_FLAG_DEFAULT, sim_section_t, a2),
                                                      CYAML_FIELD_END};
static const cyaml_schema_value_t section_schema   = {
    CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, sim_section_t, section_fields)};

static const cyaml_strval_t controller_kinds[] = {{"paper", SIM_CONTROLLER_PAPER},
                                                  {"z", SIM_CONTROLLER_Z},
                                                  {"delta", SIM_CONTROLLER_DELTA}};

static const cyaml_schema_field_t controller_fields[] = {
    CYAML_FIELD_ENUM("kind", CHOICE, sim_controller_config_t, kind, controller_kinds, COUNT(controller_kinds)),
    CYAML_FIELD_SEQUENCE("sections", OWN_VALUE, sim_controller_config_t, sections, &section_schema, 1, 4),
    CYAML_FIELD_END};

static const cyaml_schema_field_t compensator_fields[] = {
    CYAML_FIELD_FLOAT("gain", OPTIONAL, sim_compensator_config_t, gain),
    CYAML_FIELD_MAPPING("friction", OPTIONAL, sim_compensator_config_t, friction, friction_fields),
    CYAML_FIELD_MAPPING("arm", OPTIONAL, sim_compensator_config_t, arm, arm_fields),
    CYAML_FIELD_END};

static const cyaml_schema_field_t limits_fields[] = {
    CYAML_FIELD_FLOAT("u_min_N", OPTIONAL, sim_limits_config_t, u_min_n),
    CYAML_FIELD_FLOAT("u_max_N", OPTIONAL, sim_limits_config_t, u_max_n),
    CYAML_FIELD_FLOAT("input_max_N", OPTIONAL, sim_limits_config_t, input_max_n),
    CYAML_FIELD_FLOAT("full_scale_N", OPTIONAL, sim_limits_config_t, full_scale_n),
    CYAML_FIELD_END};

static const cyaml_schema_field_t metrics_fields[] = {
    CYAML_FIELD_FLOAT("start_s", OPTIONAL, sim_metrics_config_t, start_s),
    CYAML_FIELD_FLOAT_PTR("end_s", OWN_VALUE, sim_metrics_config_t, end_s),
    CYAML_FIELD_END};

static const cyaml_schema_field_t scenario_fields[] = {
    CYAML_FIELD_STRING_PTR("description", OWN_VALUE, sim_config_t, description, 0, 200),
    CYAML_FIELD_FLOAT("duration_s", OPTIONAL, sim_config_t, duration_s),
    CYAML_FIELD_FLOAT("sample_time_s", OPTIONAL, sim_config_t, sample_time_s),
    CYAML_FIELD_MAPPING("reference", OPTIONAL, sim_config_t, reference, reference_fields),
    CYAML_FIELD_MAPPING("plant", OPTIONAL, sim_config_t, plant, plant_fields),
    CYAML_FIELD_MAPPING("sensor", OPTIONAL, sim_config_t, sensor, sensor_fields),
    CYAML_FIELD_MAPPING("controller", OPTIONAL, sim_config_t, controller, controller_fields),
    CYAML_FIELD_MAPPING("compensator", OPTIONAL, sim_config_t, compensator, compensator_fields),
    CYAML_FIELD_MAPPING("limits", OPTIONAL, sim_config_t, limits, limits_fields),
    CYAML_FIELD_MAPPING("metrics", OPTIONAL, sim_config_t, metrics, metrics_fields),
    CYAML_FIELD_END};

const cyaml_schema_value_t sim_scenario_schema = {
    CYAML_VALUE_MAPPING(CYAML_FLAG_POINTER, sim_config_t, scenario_fields)};
const cyaml_schema_value_t sim_compensator_schema = {
    CYAML_VALUE_MAPPING(CYAML_FLAG_POINTER, sim_compensator_config_t, compensator_fields)};

// Every number that a scenario can hold. What the library also checks has the library's range here.
static const sim_range_t ranges[] = {
    {"duration_s", 1e-3, 86400.0},
    {"sample_time_s", 1e-6, 0.1},
    {"reference.low_N", -1e6, 1e6},
    {"reference.high_N", -1e6, 1e6},
    {"reference.start_s", 0.0, 86400.0},
    {"reference.period_s", 1e-3, 86400.0},
    {"reference.ramp_s", 1e-3, 86400.0},
    {"reference.from_Hz", 0.0, 1e6},
    {"reference.to_Hz", 0.0, 1e6},
    {"reference.sweep_s", 1e-3, 86400.0},
    {"plant.step_s", 1e-7, 0.1},
    {"plant.actuator_pole_rad_per_s", 1e-3, 1e9},
    {"friction.k_min", 1.01, 1000.0},
    {"friction.k_max", 1.01, 1000.0},
    {"friction.m", 0.0, 100.0},
    {"friction.v0_N_per_s", 1e-6, 1e6},
    {"breakaway.offset_N", 1e-6, 1e6},
    {"breakaway.slope", 0.0, 10.0},
    {"breakaway.negative_offset_N", 1e-6, 1e6},
    {"breakaway.negative_slope", 0.0, 10.0},
    {"table.force_N", 0.0, 1e6},
    {"table.positive_N", 1e-6, 1e6},
    {"table.negative_N", 1e-6, 1e6},
    {"friction.set_level", 1e-6, 1.0},
    {"friction.reset_level", 1e-6, 1.0},
    {"friction.pulse_width_s", 1e-6, 10.0},
    {"friction.gravity_N", -1e6, 1e6},
    {"arm.inertia_N_s2_per_deg", 1e-12, 1e12},
    {"arm.damping_N_s_per_deg", 0.0, 1e12},
    {"arm.stiffness_N_per_deg", 1e-12, 1e12},
    {"sensor.pole_rad_per_s", 1e-3, 1e9},
    {"sensor.noise_N", 0.0, 1e6},
    {"sensor.noise_seed", 0.0, 18446744073709551615.0},
    {"sensor.quantisation_N", 0.0, 1e6},
    {"sensor.delay_s", 0.0, 10.0},
    {"sections.b0", -1e6, 1e6},
    {"sections.b1", -1e6, 1e6},
    {"sections.b2", -1e6, 1e6},
    {"sections.a1", -4.0, 4.0},
    {"sections.a2", -4.0, 4.0},
    {"gain", 0.0, 2.0},
    {"limits.u_min_N", -1e6, 0.0},
    {"limits.u_max_N", 0.0, 1e6},
    {"limits.input_max_N", 1e-6, 1e6},
    {"limits.full_scale_N", 1e-3, 1e6},
    {"metrics.start_s", 0.0, 86400.0},
    {"metrics.end_s", 0.0, 86400.0},
};

/// Copies `path` without "[...]".
static void strip_indices(const char *path, char *stripped, size_t size)
{
    size_t length  = 0;
    bool   outside = true;
    for (const char *p = path; *p != '\0' && length + 1 < size; p++)
    {
        outside = outside && *p != '[';
        if (outside)
        {
            stripped[length++] = *p;
        }
        outside = outside || *p == ']';
    }
    stripped[length] = '\0';
}

const sim_range_t *sim_range_find(const char *path)
{
    char stripped[SIM_KEY_MAX];
    strip_indices(path, stripped, sizeof stripped);
    const size_t length = strlen(stripped);
    for (size_t i = 0; i < COUNT(ranges); i++)
    {
        const size_t tail = strlen(ranges[i].key);
        if (tail <= length && strcmp(stripped + length - tail, ranges[i].key) == 0 &&
            (tail == length || stripped[length - tail - 1] == '.'))
        {
            return &ranges[i];
        }
    }
    return NULL;
}

static const cyaml_schema_field_t *find_field(const cyaml_schema_value_t *mapping, const char *key, size_t length)
{
    for (const cyaml_schema_field_t *field = mapping->mapping.fields; field->key != NULL; field++)
    {
        if (strncmp(field->key, key, length) == 0 && field->key[length] == '\0')
        {
            return field;
        }
    }
    return NULL;
}

/// Takes "[index]" at *path; false if there is none or it is not well formed.
static bool take_index(const char **path, size_t *index)
{
    if (**path != '[' || (*path)[1] < '0' || (*path)[1] > '9')
    {
        return false;
    }
    char *end;
    *index = strtoul(*path + 1, &end, 10);
    if (*end != ']')
    {
        return false;
    }
    *path = end + 1;
    return true;
}

bool sim_schema_find(const cyaml_schema_value_t *root, const char *path, sim_place_t *place)
{
    *place                           = (sim_place_t){.parent = root};
    const cyaml_schema_value_t *next = root;
    while (next != NULL && next->type == CYAML_MAPPING)
    {
        const size_t length = strcspn(path, ".[");
        place->parent       = next;
        place->field        = find_field(next, path, length);
        place->is_element   = false;
        if (place->field == NULL)
        {
            return false;
        }
        path += length;
        next = &place->field->value;
        if (*path == '[')
        {
            if (next->type != CYAML_SEQUENCE || !take_index(&path, &place->index))
            {
                return false;
            }
            place->list        = place->field;
            place->list_offset = place->offset;
            place->is_element  = true;
            place->offset      = 0;
            next               = next->sequence.entry;
        }
        if (*path == '\0')
        {
            return true;
        }
        if (*path++ != '.')
        {
            return false;
        }
        place->offset += place->is_element ? 0 : place->field->data_offset;
    }
    return false;
}

static void visit_fields(const cyaml_schema_value_t *mapping,
                         char                       *path,
                         size_t                      length,
                         sim_key_visitor_t           visit,
                         void                       *context)
{
    for (const cyaml_schema_field_t *field = mapping->mapping.fields; field->key != NULL; field++)
    {
        const size_t room = SIM_KEY_MAX - length;
        const size_t end  = length + (size_t)snprintf(path + length, room, "%s%s", length > 0 ? "." : "", field->key);
        visit(context, path, field);
        if (field->value.type == CYAML_MAPPING)
        {
            visit_fields(&field->value, path, end, visit, context);
        }
        if (field->value.type == CYAML_SEQUENCE)
        {
            (void)snprintf(path + end, SIM_KEY_MAX - end, "[]");
            visit_fields(field->value.sequence.entry, path, end + 2, visit, context);
        }
        path[length] = '\0';
    }
}

void sim_schema_visit(const cyaml_schema_value_t *root, sim_key_visitor_t visit, void *context)
{
    char path[SIM_KEY_MAX] = "";
    visit_fields(root, path, 0, visit, context);
}

const char *sim_schema_type_name(const cyaml_schema_value_t *value)
{
    switch (value->type)
    {
    case CYAML_FLOAT:
        return "a number";
    case CYAML_UINT:
        return "a whole number";
    case CYAML_STRING:
        return "text";
    case CYAML_MAPPING:
        return "a mapping";
    case CYAML_SEQUENCE:
        return "a list";
    default:
        return "a word";
    }
}

void sim_schema_choices(const cyaml_schema_value_t *value, char *text, size_t size)
{
    const uint32_t count  = value->enumeration.count;
    size_t         length = 0;
    text[0]               = '\0';
    for (uint32_t i = 0; i < count && length < size; i++)
    {
        const char *separator = (i == 0) ? "" : (i + 1 == count) ? " or " : ", ";
        length += (size_t)snprintf(text + length, size - length, "%s%s", separator, value->enumeration.strings[i].str);
    }
}
