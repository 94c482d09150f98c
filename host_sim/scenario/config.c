#include "scenario/config.h"

#include "scenario/keys.h"

common_scenario_t *sim_scenario_create(void)
{
    return common_scenario_create_of(sim_keys, sizeof(sim_config_t));
}

const sim_config_t *sim_scenario_config(const common_scenario_t *scenario)
{
    return common_scenario_values(scenario);
}
