#include "scenario/check.h"

#include <math.h>

static bool check_sensor(const common_scenario_t *scenario, common_error_t *error)
{
    // A finer step than this would overflow on the way to a whole number of steps.
    const double step_n = sim_scenario_config(scenario)->sensor.sampling.quantisation_n;
    return step_n == 0.0 || step_n >= 1e-12 ||
           common_check_complain(scenario, "sensor.quantisation_N", "must be 0 or at least 1e-12", error);
}

static bool check_times(const common_scenario_t *scenario, common_error_t *error)
{
    const sim_config_t *config = sim_scenario_config(scenario);
    const double        ticks  = round(config->duration_s / config->loop.sample_time_s);
    if (ticks < 1.0)
    {
        return common_check_complain(scenario, "duration_s", "is shorter than one sample", error);
    }
    const double steps = config->loop.sample_time_s / config->plant.step_s;
    if (fabs(steps - round(steps)) > 1e-6 * steps)
    {
        return common_check_complain(scenario, "plant.step_s", "must divide sample_time_s without a remainder", error);
    }
    const double end = config->metrics.end_s.is_given ? config->metrics.end_s.value : config->duration_s;
    if (end > config->duration_s)
    {
        return common_check_complain(scenario, "metrics.end_s", "is after the end of the run", error);
    }
    if (!(config->metrics.start_s < end))
    {
        return common_check_complain(scenario, "metrics.start_s", "leaves no time before the window's end", error);
    }
    return true;
}

bool sim_check_has_firmware(const common_scenario_t *scenario, common_error_t *error)
{
    return common_check_has_loop(scenario, error);
}

bool sim_scenario_check(const common_scenario_t *scenario, common_error_t *error)
{
    return common_check_present(scenario, error) && check_times(scenario, error) && check_sensor(scenario, error) &&
           common_check_friction(scenario, &sim_scenario_config(scenario)->plant.friction, "plant", error) &&
           common_check_loop(scenario, error);
}
