#include "scenario/config.h"

#include "scenario/keys.h"

sim_scenario_t *sim_scenario_create(void)
{
    return sim_scenario_create_of(sim_keys, sizeof(sim_config_t));
}

const sim_config_t *sim_scenario_config(const sim_scenario_t *scenario)
{
    return sim_scenario_values(scenario);
}
