#include "scenario/plant_config.h"

#include <math.h>

unsigned sim_plant_steps(const sim_config_t *config)
{
    return (unsigned)round(config->loop.sample_time_s / config->plant.step_s);
}

sim_plant_config_t sim_plant_config_of(const sim_config_t *config)
{
    return (sim_plant_config_t){.step_s                  = config->loop.sample_time_s / sim_plant_steps(config),
                                .actuator_pole_rad_per_s = config->plant.actuator_pole_rad_per_s,
                                .sensor_pole_rad_per_s   = config->sensor.pole_rad_per_s,
                                .truth                   = {.friction = config->plant.friction,
                                                            .arm      = config->plant.arm,
                                                            .own      = config->plant.own[config->plant.model]},
                                .drive_error             = config->plant.drive_error};
}
