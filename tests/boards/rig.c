// The paper's plant behind a pipe, for tests of a board's image: reads u in N, a double, holds it for a tick of 1 ms and writes what
// the sensor then shows and the end-point force, two doubles; until the pipe ends.

#include "plant/plant.h"
#include "plant/truth.h"
#include "scenario/config.h"

#include <stdio.h>

#define STEPS_A_TICK 10

int main(void)
{
    common_scenario_t *scenario = sim_scenario_create();
    if (scenario == NULL)
    {
        return 1;
    }
    const sim_config_t      *config = sim_scenario_config(scenario);
    const sim_plant_config_t of     = {.step_s                  = 1e-3 / STEPS_A_TICK,
                                       .actuator_pole_rad_per_s = config->plant.actuator_pole_rad_per_s,
                                       .sensor_pole_rad_per_s   = config->sensor.pole_rad_per_s,
                                       .truth                   = {.friction = config->plant.friction,
                                                                   .arm      = config->plant.arm,
                                                                   .own      = config->plant.own[config->plant.model]}};
    sim_plant_t             *plant  = sim_plant_create(&of, sim_truth_models[config->plant.model]);
    double                   u_n;
    while (plant != NULL && fread(&u_n, sizeof u_n, 1, stdin) == 1)
    {
        for (int i = 0; i < STEPS_A_TICK; i++)
        {
            sim_plant_signals_t unused;
            sim_plant_step(plant, u_n, &unused);
        }
        const double seen[2] = {sim_plant_filtered_force(plant), sim_plant_force(plant)};
        if (fwrite(seen, sizeof seen, 1, stdout) != 1 || fflush(stdout) != 0)
        {
            break;
        }
    }
    sim_plant_destroy(plant);
    common_scenario_destroy(scenario);
    return 0;
}
