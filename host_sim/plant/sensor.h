/// Turns the filtered force into the samples of the control loop: first a delay, then noise (white, Gaussian, one deviate a
/// sample), then rounding to the sensor's step. A value of 0 turns each off.

#ifndef SIM_SENSOR_H
#define SIM_SENSOR_H

#include "plant/random.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct
{
    double   noise_n; ///< standard deviation
    uint64_t noise_seed;
    double   quantisation_n; ///< distance between two readings
    double   delay_s;        ///< rounded to whole plant steps
} sim_sensor_config_t;

typedef struct
{
    sim_sensor_config_t config;
    sim_random_t        random;
    double             *line; ///< past filtered forces, a ring
    size_t              length, head;
} sim_sensor_t;

/// Starts the sensor at rest at 0 N. Returns false if there is no memory; nothing is left to free then.
bool sim_sensor_init(sim_sensor_t *sensor, const sim_sensor_config_t *config, double plant_step_s);
void sim_sensor_free(sim_sensor_t *sensor);

/// Stores the filtered force before each plant step. It is inline because most sensors have no delay and store nothing.
static inline void sim_sensor_push(sim_sensor_t *sensor, double filtered_n)
{
    if (sensor->length > 0)
    {
        sensor->line[sensor->head] = filtered_n;
        sensor->head               = (sensor->head + 1 == sensor->length) ? 0 : sensor->head + 1;
    }
}

/// Returns one reading for the present filtered force `filtered_n`, which has not been stored yet.
double sim_sensor_read(sim_sensor_t *sensor, double filtered_n);

#endif
