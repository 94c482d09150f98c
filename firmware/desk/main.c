// tribo-desk runs the drive of firmware/port/linux on the plant of its scenario instead of devices and lines, on any machine.
//
// This is the only code of the firmware that knows the simulator.

#include "port/linux/program.h"

#include "plant/plant.h"
#include "plant/sensor.h"
#include "scenario/keys.h"
#include "scenario/plant_config.h"

#include <stdlib.h>

typedef struct
{
    sim_plant_config_t config;
    sim_plant_t       *plant;
    sim_sensor_t       sensor;
    unsigned           steps; ///< plant steps in a tick
} desk_plant_t;

static void close_plant(void *context)
{
    desk_plant_t *desk = context;
    if (desk != NULL)
    {
        sim_plant_destroy(desk->plant);
        sim_sensor_free(&desk->sensor);
        free(desk);
    }
}

static void *open_plant(const common_scenario_t *scenario, common_error_t *error)
{
    const sim_config_t *config = sim_scenario_config(scenario);
    desk_plant_t       *desk   = calloc(1, sizeof *desk);
    if (desk != NULL)
    {
        desk->steps  = sim_plant_steps(config);
        desk->config = sim_plant_config_of(config);
        desk->plant  = sim_plant_create(&desk->config, sim_truth_models[config->plant.model]);
    }
    if (desk == NULL || desk->plant == NULL ||
        !sim_sensor_init(&desk->sensor, &config->sensor.sampling, desk->config.step_s))
    {
        close_plant(desk);
        (void)common_error_set(error, "out of memory");
        return NULL;
    }
    return desk;
}

static double read_sensor(void *context)
{
    desk_plant_t *desk = context;
    return sim_sensor_read(&desk->sensor, sim_plant_filtered_force(desk->plant));
}

static void advance(void *context, double u_n)
{
    desk_plant_t       *desk = context;
    sim_plant_signals_t unused;
    for (unsigned i = 0; i < desk->steps; i++)
    {
        sim_sensor_push(&desk->sensor, sim_plant_filtered_force(desk->plant));
        sim_plant_step(desk->plant, u_n, &unused);
    }
}

int main(int count, char **arguments)
{
    static const desk_t desk = {.keys    = sim_keys,
                                .size    = sizeof(sim_config_t),
                                .check   = sim_scenario_check,
                                .open    = open_plant,
                                .close   = close_plant,
                                .read    = read_sensor,
                                .advance = advance};
    return program_run(count, arguments, &desk);
}
