#include "scenario/check.h"

#include "scenario/keys.h"
#include "scenario/loop.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static bool complain(const sim_scenario_t *scenario, const char *key, const char *what, sim_error_t *error)
{
    return sim_error_set(error, "%s: %s: %s", sim_scenario_source(scenario, key), key, what);
}

typedef struct
{
    const sim_scenario_t *scenario;
    char                 *missing; ///< the first key
} required_t;

static void find_missing(void *context, const char *path, const sim_key_t *key)
{
    const required_t *required = context;
    // That an element of a list has all its keys was checked where it was read.
    if (key->is_required && required->missing[0] == '\0' && strchr(path, '[') == NULL &&
        !sim_scenario_has(required->scenario, path))
    {
        (void)snprintf(required->missing, SIM_KEY_MAX, "%s", path);
    }
}

static bool check_present(const sim_scenario_t *scenario, sim_error_t *error)
{
    const sim_reference_config_t *reference            = &sim_scenario_config(scenario)->reference;
    char                          missing[SIM_KEY_MAX] = "";
    required_t                    required             = {.scenario = scenario, .missing = missing};
    sim_key_visit(find_missing, &required);
    if (missing[0] != '\0')
    {
        return complain(scenario, missing, "is missing", error);
    }
    if (reference->kind == SIM_REFERENCE_CSV && reference->file[0] == '\0')
    {
        return complain(scenario, "reference.file", "is missing, reference.kind is csv", error);
    }
    return true;
}

static bool check_sensor(const sim_scenario_t *scenario, sim_error_t *error)
{
    // A finer step than this would overflow on the way to a whole number of steps.
    const double step_n = sim_scenario_config(scenario)->sensor.sampling.quantisation_n;
    return step_n == 0.0 || step_n >= 1e-12 ||
           complain(scenario, "sensor.quantisation_N", "must be 0 or at least 1e-12", error);
}

static bool check_times(const sim_scenario_t *scenario, sim_error_t *error)
{
    const sim_config_t *config = sim_scenario_config(scenario);
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
    const double end = config->metrics.end_s.is_given ? config->metrics.end_s.value : config->duration_s;
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

/// "WHOSE.friction." and the rest, as a key.
static const char *friction_key(char key[SIM_KEY_MAX], const char *whose, const char *rest)
{
    (void)snprintf(key, SIM_KEY_MAX, "%s.friction.%s", whose, rest);
    return key;
}

static bool check_friction(const sim_scenario_t        *scenario,
                           const sim_friction_config_t *friction,
                           const char                  *whose,
                           sim_error_t                 *error)
{
    static const char *const law[] = {"offset_N", "slope", "negative_offset_N", "negative_slope"};

    const sim_breakaway_point_t *points = friction->breakaway.table;
    char                         table[SIM_KEY_MAX], key[2 * SIM_KEY_MAX];
    if (friction->k_min > friction->k_max)
    {
        return complain(scenario, friction_key(key, whose, "k_min"), "is larger than k_max", error);
    }
    (void)friction_key(table, whose, "breakaway.table");
    for (size_t i = 0; friction->breakaway.table_count > 0 && i < sizeof law / sizeof law[0]; i++)
    {
        (void)snprintf(key, sizeof key, "%s.friction.breakaway.%s", whose, law[i]);
        // A table of --set goes over a file's law.
        if (sim_scenario_has(scenario, key) &&
            (sim_scenario_is_set(scenario, key) || !sim_scenario_is_set(scenario, table)))
        {
            return complain(scenario, key, "does not go with a table, which is in its place", error);
        }
    }
    for (unsigned i = 1; i < friction->breakaway.table_count; i++)
    {
        if (!(points[i].force_n > points[i - 1].force_n))
        {
            (void)snprintf(key, sizeof key, "%s[%u].force_N", table, i);
            return complain(scenario, key, "must be larger than in the point before", error);
        }
    }
    return true;
}

static bool check_controller(const sim_scenario_t *scenario, sim_error_t *error)
{
    const sim_config_t *config = sim_scenario_config(scenario);
    const bool          paper  = config->controller.kind == SIM_CONTROLLER_PAPER;
    const bool own = config->controller.kind == SIM_CONTROLLER_Z || config->controller.kind == SIM_CONTROLLER_DELTA;
    if (!own && config->controller.section_count > 0)
    {
        return complain(scenario, "controller.sections", "go with controller.kind z or delta alone", error);
    }
    if (own && config->controller.section_count == 0)
    {
        return complain(scenario, "controller.sections", "is missing, controller.kind is z or delta", error);
    }
    if (paper && fabs(config->sample_time_s - 1e-3) > 1e-9)
    {
        return complain(scenario, "sample_time_s", "must be 0.001 with controller.kind paper", error);
    }
    return true;
}

/// The key of the first section that alone is refused with `status`; false if there is none.
static bool find_section(const sim_config_t *config, tribo_status_t status, char key[SIM_KEY_MAX])
{
    sim_loop_config_t             loop;
    tribo_controller_f32_params_t params;
    sim_loop_config_fill(&loop, config);
    for (unsigned i = 0; i < config->controller.section_count; i++)
    {
        const tribo_controller_f32_config_t one = {.sections      = &loop.sections[i],
                                                   .section_count = 1,
                                                   .u_min_n       = -1.0f,
                                                   .u_max_n       = 1.0f};
        if (tribo_controller_f32_init(&params, &one) == status)
        {
            (void)snprintf(key, SIM_KEY_MAX, "controller.sections[%u]", i);
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
    sim_config_t                  config = *sim_scenario_config(scenario);
    const sim_breakaway_config_t *law    = &config.compensator.friction.breakaway;
    const char                   *text   = tribo_status_text(status);
    char                          key[SIM_KEY_MAX];
    char                          with_value[256];
    sim_place_t                   place;
    double                        value;
    sim_key_of_status(status, key);
    if ((status == TRIBO_ERR_BREAKAWAY_OFFSET && law->negative_offset_n.is_given) ||
        (status == TRIBO_ERR_BREAKAWAY_SLOPE && law->negative_slope.is_given))
    {
        (void)snprintf(key, sizeof key, "compensator.friction.breakaway"); // of either direction
    }
    else if (strcmp(key, "controller.sections") == 0 && find_section(&config, status, key))
    {
        return complain(scenario, key, text, error);
    }
    if (sim_key_find(&config, key, &place) && place.key->type == SIM_KEY_NUMBER)
    {
        memcpy(&value, place.at, sizeof value);
        (void)snprintf(with_value, sizeof with_value, "%.10g is refused: %s", value, text);
        text = with_value;
    }
    return complain(scenario, key[0] != '\0' ? key : "scenario", text, error);
}

bool sim_check_compensator(const sim_scenario_t *scenario, sim_error_t *error)
{
    const sim_compensator_config_t *compensator = &sim_scenario_config(scenario)->compensator;
    if (compensator->model == SIM_MODEL_LUGRE && compensator->method == SIM_METHOD_FEEDFORWARD)
    {
        return complain(scenario, "compensator.model", "lugre goes with compensator.method paper or off alone", error);
    }
    return check_friction(scenario, &sim_scenario_config(scenario)->compensator.friction, "compensator", error);
}

bool sim_check_has_loop(const sim_scenario_t *scenario, sim_error_t *error)
{
    const sim_config_t *config = sim_scenario_config(scenario);
    return config->controller.kind != SIM_CONTROLLER_NONE ||
           complain(scenario, "controller.kind", "none is open loop, without a loop for a drive", error);
}

bool sim_check_has_firmware(const sim_scenario_t *scenario, sim_error_t *error)
{
    return sim_check_has_loop(scenario, error) &&
           (sim_scenario_config(scenario)->compensator.model != SIM_MODEL_LUGRE ||
            complain(scenario,
                     "compensator.model",
                     "lugre is not in the drive's firmware, which has no registers for it; it runs here and in params",
                     error));
}

bool sim_scenario_check(const sim_scenario_t *scenario, sim_error_t *error)
{
    const sim_config_t *config = sim_scenario_config(scenario);
    if (!(check_present(scenario, error) && check_times(scenario, error) && check_sensor(scenario, error) &&
          check_friction(scenario, &config->plant.friction, "plant", error) && sim_check_compensator(scenario, error) &&
          check_controller(scenario, error)))
    {
        return false;
    }
    sim_loop_config_t loop_config;
    sim_loop_t        loop;
    sim_loop_config_fill(&loop_config, config);
    return sim_check_status(scenario, sim_loop_init(&loop, false, &loop_config, config->limits.full_scale_n), error);
}
