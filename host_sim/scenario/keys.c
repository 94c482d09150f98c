// The list of all keys, for `tribo-sim list --keys` and for the test that compares it with scenarios/README.md.

#include "scenario/scenario_data.h"
#include "scenario/schema.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>

static void print_default(const sim_config_t *config, const char *path, const cyaml_schema_value_t *value)
{
    sim_place_t place;
    double      number;
    uint64_t    whole;
    int         choice;
    // Elements of lists ("[]") are not found: they have no defaults.
    if (strchr(path, '[') != NULL || !sim_schema_find(&sim_scenario_schema, path, &place) ||
        (value->flags & CYAML_FLAG_POINTER) != 0 || strcmp(path, "duration_s") == 0 ||
        strcmp(path, "reference.kind") == 0)
    {
        (void)printf("-\n");
        return;
    }
    const char *at = (const char *)config + place.offset + place.field->data_offset;
    switch (value->type)
    {
    case CYAML_FLOAT:
        memcpy(&number, at, sizeof number);
        (void)printf("%g\n", number);
        break;
    case CYAML_UINT:
        memcpy(&whole, at, sizeof whole);
        (void)printf("%llu\n", (unsigned long long)whole);
        break;
    default:
        memcpy(&choice, at, sizeof choice);
        (void)printf("%s\n", value->enumeration.strings[choice].str);
        break;
    }
}

static void print_key(void *context, const char *path, const cyaml_schema_field_t *field)
{
    const sim_config_t *config = context;
    if (field->value.type == CYAML_MAPPING)
    {
        return;
    }
    (void)printf("%s | ", path);
    if (field->value.type == CYAML_ENUM)
    {
        char choices[128];
        sim_schema_choices(&field->value, choices, sizeof choices);
        (void)printf("%s | - | ", choices);
    }
    else
    {
        (void)printf("%s | ", sim_schema_type_name(&field->value));
        const sim_range_t *range = sim_range_find(path);
        if (range == NULL)
        {
            (void)printf("- | ");
        }
        else
        {
            (void)printf("%g to %g | ", range->min, range->max);
        }
    }
    print_default(config, path, &field->value);
}

bool sim_scenario_print_keys(void)
{
    sim_scenario_t *scenario = sim_scenario_create();
    if (scenario == NULL)
    {
        return false;
    }
    sim_schema_visit(&sim_scenario_schema, print_key, scenario->config);
    sim_scenario_destroy(scenario);
    return true;
}
