// tribo-fmu-describe SCENARIO.yaml: the scenario's values and the columns of a run, for tools/tribo-fmu. Fields are separated by tabs:
//
//     value   KEY UNIT MIN MAX NUMBER WHOLE CHANGE TEXT     UNIT: of a choice its word
//                                                          CHANGE: tunable, fixed, or - for what an FMU keeps as it is
//     length  LIST COUNT
//     column  NAME FLAG

#include "keys/table.h"
#include "scenario/columns.h"
#include "scenario/keys.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

static const char *change_of(const char *key, const common_key_t *row)
{
#define ROW(group, symbol, member, key_, unit, low, high, standard, change, ...)                                       \
    {TRIBO_KEY_##group key_, TRIBO_##change},
    static const struct
    {
        const char *key;
        int         change;
    } rows[] = {TRIBO_PARAMETERS(ROW)};
#undef ROW
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
    {
        if (strcmp(rows[i].key, key) == 0)
        {
            return rows[i].change == TRIBO_TUNES ? "tunable" : "fixed";
        }
    }
    return row->type == COMMON_KEY_NUMBER || row->type == COMMON_KEY_OPTIONAL ? "fixed" : "-";
}

static void print_value(sim_config_t *config, const char *key)
{
    common_place_t    place;
    common_optional_t optional;
    double            number = 0.0;
    uint64_t          whole  = 0;
    const char       *unit   = "-";
    int               word   = 0;
    (void)common_key_find(sim_keys, config, key, &place);
    switch (place.key->type)
    {
    case COMMON_KEY_NUMBER:
        memcpy(&number, place.at, sizeof number);
        break;
    case COMMON_KEY_OPTIONAL:
        memcpy(&optional, place.at, sizeof optional);
        if (!optional.is_given)
        {
            return;
        }
        number = optional.value;
        break;
    case COMMON_KEY_WHOLE:
        memcpy(&whole, place.at, sizeof whole);
        break;
    case COMMON_KEY_CHOICE:
        memcpy(&word, place.at, sizeof word);
        number = word;
        unit   = place.key->words[word];
        break;
    default:
        return;
    }
    (void)printf("value\t%s\t%s\t%.17g\t%.17g\t%.17g\t%" PRIu64 "\t%s\t%s\n",
                 key,
                 place.key->type != COMMON_KEY_CHOICE && place.key->unit != NULL ? place.key->unit : unit,
                 place.key->min,
                 place.key->max,
                 number,
                 whole,
                 change_of(key, place.key),
                 place.key->text != NULL ? place.key->text : "");
}

/// A key, of a list each element's.
static void print(void *context, const char *path, const common_key_t *key)
{
    sim_config_t *config = context;
    const char   *mark   = strstr(path, "[]");
    if (key->type == COMMON_KEY_LIST)
    {
        common_place_t place;
        unsigned       count;
        (void)common_key_find(sim_keys, config, path, &place);
        memcpy(&count, place.at - key->offset + key->count_offset, sizeof count);
        (void)printf("length\t%s\t%u\n", path, count);
    }
    else if (mark == NULL)
    {
        print_value(config, path);
    }
    else
    {
        char           element[COMMON_KEY_MAX + 12];
        common_place_t place;
        for (unsigned i = 0;; i++)
        {
            (void)snprintf(element, sizeof element, "%.*s[%u]%s", (int)(mark - path), path, i, mark + 2);
            if (!common_key_find(sim_keys, config, element, &place) || place.at == NULL || i >= place.count)
            {
                return;
            }
            print_value(config, element);
        }
    }
}

int main(int count, char **arguments)
{
    common_error_t     error    = {""};
    common_scenario_t *scenario = sim_scenario_create();
    if (count != 2 || scenario == NULL || !common_scenario_load(scenario, arguments[1], &error) ||
        !sim_scenario_check(scenario, &error))
    {
        (void)fprintf(stderr, "%s\n", error.text[0] != '\0' ? error.text : "usage: tribo-fmu-describe SCENARIO.yaml");
        common_scenario_destroy(scenario);
        return 1;
    }
    sim_config_t config = *sim_scenario_config(scenario);
    common_key_visit(sim_keys, print, &config);
    for (unsigned i = 0; i < sim_column_count(sim_run_learns(&config)); i++)
    {
        (void)printf("column\t%s\t%d\n", sim_columns[i].name, sim_columns[i].is_flag);
    }
    common_scenario_destroy(scenario);
    return 0;
}
