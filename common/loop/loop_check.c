#include "loop/loop_check.h"

#include "keys/table.h"
#include "loop/loop_config.h"
#include "tribo/force_loop_q31.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

bool common_check_complain(const common_scenario_t *scenario, const char *key, const char *what, common_error_t *error)
{
    return common_error_set(error, "%s: %s: %s", common_scenario_source(scenario, key), key, what);
}

typedef struct
{
    const common_scenario_t *scenario;
    char                    *missing; ///< the first key
} required_t;

static void find_missing(void *context, const char *path, const common_key_t *key)
{
    const required_t *required = context;
    // The reader has already checked that an element of a list has all its keys.
    if (key->is_required && required->missing[0] == '\0' && strchr(path, '[') == NULL &&
        !common_scenario_has(required->scenario, path))
    {
        (void)snprintf(required->missing, COMMON_KEY_MAX, "%s", path);
    }
}

bool common_check_present(const common_scenario_t *scenario, common_error_t *error)
{
    const common_reference_config_t *reference               = &common_scenario_loop(scenario)->reference;
    char                             missing[COMMON_KEY_MAX] = "";
    required_t                       required                = {.scenario = scenario, .missing = missing};
    common_key_visit(common_scenario_keys(scenario), find_missing, &required);
    if (missing[0] != '\0')
    {
        return common_check_complain(scenario, missing, "is missing", error);
    }
    if (reference->kind == COMMON_REFERENCE_CSV && reference->file[0] == '\0')
    {
        return common_check_complain(scenario, "reference.file", "is missing; reference.kind csv needs it", error);
    }
    return true;
}

/// Writes the key "WHOSE.friction.REST".
static const char *friction_key(char key[COMMON_KEY_MAX], const char *whose, const char *rest)
{
    (void)snprintf(key, COMMON_KEY_MAX, "%s.friction.%s", whose, rest);
    return key;
}

bool common_check_friction(const common_scenario_t        *scenario,
                           const common_friction_config_t *friction,
                           const char                     *whose,
                           common_error_t                 *error)
{
    static const char *const law[] = {"offset_N", "slope", "negative_offset_N", "negative_slope"};

    const common_breakaway_point_t *points = friction->breakaway.table;
    char                            table[COMMON_KEY_MAX], key[2 * COMMON_KEY_MAX];
    if (friction->k_min > friction->k_max)
    {
        return common_check_complain(scenario, friction_key(key, whose, "k_min"), "is larger than k_max", error);
    }
    (void)friction_key(table, whose, "breakaway.table");
    for (size_t i = 0; friction->breakaway.table_count > 0 && i < sizeof law / sizeof law[0]; i++)
    {
        (void)snprintf(key, sizeof key, "%s.friction.breakaway.%s", whose, law[i]);
        // A table given by --set replaces the law in a file.
        if (common_scenario_has(scenario, key) &&
            (common_scenario_is_set(scenario, key) || !common_scenario_is_set(scenario, table)))
        {
            return common_check_complain(scenario, key, "is not allowed with a table, which replaces it", error);
        }
    }
    for (unsigned i = 1; i < friction->breakaway.table_count; i++)
    {
        if (!(points[i].force_n > points[i - 1].force_n))
        {
            (void)snprintf(key, sizeof key, "%s[%u].force_N", table, i);
            return common_check_complain(scenario, key, "must be larger than in the point before", error);
        }
    }
    return true;
}

static bool check_pi(const common_scenario_t *scenario, common_error_t *error)
{
    static const char *const        gains[] = {"controller.kp", "controller.ki_per_s"};
    const common_loop_keys_t *const keys    = common_scenario_loop(scenario);
    if (keys->controller.kind != COMMON_CONTROLLER_PI)
    {
        for (size_t i = 0; i < sizeof gains / sizeof gains[0]; i++)
        {
            if (common_scenario_has(scenario, gains[i]))
            {
                return common_check_complain(scenario, gains[i], "is allowed only with controller.kind pi", error);
            }
        }
        return true;
    }
    if (!common_scenario_has(scenario, gains[0]))
    {
        return common_check_complain(scenario, gains[0], "is missing; controller.kind pi needs it", error);
    }
    return keys->controller.ki_per_s * keys->sample_time_s <= 2.0 * keys->controller.kp ||
           common_check_complain(scenario, gains[1], "times sample_time_s must be at most 2 controller.kp", error);
}

static bool check_controller(const common_scenario_t *scenario, common_error_t *error)
{
    const common_loop_keys_t *config = common_scenario_loop(scenario);
    const bool                paper  = config->controller.kind == COMMON_CONTROLLER_PAPER;
    const bool                own =
        config->controller.kind == COMMON_CONTROLLER_Z || config->controller.kind == COMMON_CONTROLLER_DELTA;
    if (!own && config->controller.section_count > 0)
    {
        return common_check_complain(scenario,
                                     "controller.sections",
                                     "are allowed only with controller.kind z or delta",
                                     error);
    }
    if (own && config->controller.section_count == 0)
    {
        return common_check_complain(scenario,
                                     "controller.sections",
                                     "is missing; controller.kind z or delta needs it",
                                     error);
    }
    if (!check_pi(scenario, error))
    {
        return false;
    }
    if (paper && fabs(config->sample_time_s - 1e-3) > 1e-9)
    {
        return common_check_complain(scenario, "sample_time_s", "must be 0.001 with controller.kind paper", error);
    }
    return true;
}

bool common_check_compensator(const common_scenario_t *scenario, common_error_t *error)
{
    const common_compensator_config_t *compensator = &common_scenario_loop(scenario)->compensator;
    if (compensator->sensor == COMMON_SENSOR_NONE && compensator->method != COMMON_METHOD_FEEDFORWARD)
    {
        return common_check_complain(scenario,
                                     "compensator.sensor",
                                     "none is allowed only with compensator.method feedforward",
                                     error);
    }
    return common_check_friction(scenario, &common_scenario_loop(scenario)->compensator.friction, "compensator", error);
}

bool common_check_has_loop(const common_scenario_t *scenario, common_error_t *error)
{
    const common_loop_keys_t *config = common_scenario_loop(scenario);
    return config->controller.kind != COMMON_CONTROLLER_NONE ||
           common_check_complain(scenario,
                                 "controller.kind",
                                 "none is an open loop, but a drive needs a closed one",
                                 error);
}

/// Writes the key that the library refuses; in a list, that of the section or of the number in the breakaway table.
static void name_refused(const common_loop_keys_t *keys, tribo_status_t status, char key[COMMON_KEY_MAX])
{
#define NUMBER_KEY(symbol, member, key, unit, low, high, sentence) key,
    static const char *const      numbers[] = {TRIBO_POINT_ELEMENTS(NUMBER_KEY)};
    tribo_refusal_t               refusal   = {0};
    common_loop_config_t          loop;
    tribo_breakaway_point_q31_t   table[TRIBO_BREAKAWAY_POINTS_MAX];
    tribo_force_loop_q31_params_t params;
    common_loop_config_fill(&loop, keys);
    tribo_force_loop_q31_config_t config     = {.loop         = loop.parts.config,
                                                .full_scale_n = (float)keys->limits.full_scale_n,
                                                .table        = table};
    config.loop.controller.refusal           = &refusal;
    config.loop.compensator.friction.refusal = &refusal;
    (void)tribo_force_loop_q31_init(&params, &config); // refuses everything that f32 refuses
    switch (status)
    {
    case TRIBO_ERR_SECTION_COEFFICIENT:
    case TRIBO_ERR_SECTION_FEEDTHROUGH:
    case TRIBO_ERR_SECTION_UNSTABLE:
        (void)snprintf(key, COMMON_KEY_MAX, "controller.sections[%u]", (unsigned)refusal.index);
        break;
    case TRIBO_ERR_TABLE_FORCE:
    case TRIBO_ERR_TABLE_POSITIVE:
    case TRIBO_ERR_TABLE_NEGATIVE:
        (void)snprintf(key,
                       COMMON_KEY_MAX,
                       "compensator.friction.breakaway.table[%u].%s",
                       (unsigned)refusal.index,
                       numbers[refusal.member]);
        break;
    default:
        (void)snprintf(key, COMMON_KEY_MAX, "%s", common_loop_key_of(status));
        break;
    }
}

/// Reads the number at a key's place. Returns false if there is none.
static bool number_at(const common_place_t *place, double *value)
{
    common_optional_t optional;
    switch (place->at != NULL ? place->key->type : COMMON_KEY_GROUP)
    {
    case COMMON_KEY_NUMBER:
        memcpy(value, place->at, sizeof *value);
        return true;
    case COMMON_KEY_OPTIONAL:
        memcpy(&optional, place->at, sizeof optional);
        *value = optional.value;
        return optional.is_given;
    default:
        return false;
    }
}

bool common_check_status(const common_scenario_t *scenario, tribo_status_t status, common_error_t *error)
{
    if (status == TRIBO_OK)
    {
        return true;
    }
    const common_loop_keys_t *loop = common_scenario_loop(scenario);
    const char               *text = tribo_status_text(status);
    char                      key[COMMON_KEY_MAX];
    char                      with_value[256];
    char                      of_kind[320];
    common_place_t            place;
    double                    value;
    name_refused(loop, status, key);
    if (common_key_find(common_scenario_keys(scenario), (void *)common_scenario_values(scenario), key, &place) &&
        number_at(&place, &value))
    {
        const char *const unit = place.key->unit[0] == '-' ? "" : place.key->unit;
        (void)snprintf(with_value,
                       sizeof with_value,
                       "%.10g%s%s is refused: %s",
                       value,
                       unit[0] != '\0' ? " " : "",
                       unit,
                       text);
        text = with_value;
    }
    if (status == TRIBO_ERR_SECTION_UNSTABLE) // coefficients of one kind are often unstable when read as the other kind
    {
        const bool z = loop->controller.kind == COMMON_CONTROLLER_Z;
        (void)snprintf(of_kind,
                       sizeof of_kind,
                       "%s; read as controller.kind %s",
                       text,
                       z ? "z, in z^-1" : "delta, in z - 1");
        text = of_kind;
    }
    return common_check_complain(scenario, key[0] != '\0' ? key : "scenario", text, error);
}

bool common_check_loop(const common_scenario_t *scenario, common_error_t *error)
{
    common_loop_config_t config;
    common_loop_config_fill(&config, common_scenario_loop(scenario));
    return common_check_compensator(scenario, error) && check_controller(scenario, error) &&
           common_check_status(scenario, common_loop_config_status(&config), error);
}
