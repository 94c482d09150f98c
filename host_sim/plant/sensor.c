#include "plant/sensor.h"

#include <math.h>
#include <stdlib.h>

bool sim_sensor_init(sim_sensor_t *sensor, const sim_sensor_config_t *config, double plant_step_s)
{
    *sensor = (sim_sensor_t){.config = *config};
    sim_random_seed(&sensor->random, config->noise_seed);
    sensor->length = (size_t)round(config->delay_s / plant_step_s);
    sensor->line   = (sensor->length > 0) ? calloc(sensor->length, sizeof *sensor->line) : NULL;
    return sensor->length == 0 || sensor->line != NULL;
}

void sim_sensor_free(sim_sensor_t *sensor)
{
    free(sensor->line);
    *sensor = (sim_sensor_t){0};
}

double sim_sensor_read(sim_sensor_t *sensor, double filtered_n)
{
    // The oldest entry of the ring was pushed `length` steps ago.
    double y = (sensor->length > 0) ? sensor->line[sensor->head] : filtered_n;
    if (sensor->config.noise_n > 0.0)
    {
        y += sensor->config.noise_n * sim_random_normal(&sensor->random);
    }
    if (sensor->config.quantisation_n > 0.0)
    {
        y = sensor->config.quantisation_n * round(y / sensor->config.quantisation_n);
    }
    return y;
}
