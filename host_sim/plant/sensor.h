/// What turns the filtered force into the samples the control loop reads: first the delay, then the noise (white,
/// Gaussian, one deviate a sample), then the rounding to the sensor's step. All three are off at 0.

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
    double   quantisation_n; ///< distance of two readings
    double   delay_s;        ///< rounded to whole plant steps
} sim_sensor_config_t;

typedef struct
{
    sim_sensor_config_t config;
    sim_random_t        random;
    double             *line; ///< past filtered forces, a ring
    size_t              length, head;
} sim_sensor_t;

/// At rest at 0 N. False if there is no memory; then nothing is left to free.
bool sim_sensor_init(sim_sensor_t *sensor, const sim_sensor_config_t *config, double plant_step_s);
void sim_sensor_free(sim_sensor_t *sensor);

/// Takes the filtered force before each plant step.
void sim_sensor_push(sim_sensor_t *sensor, double filtered_n);

/// One reading, with the filtered force `filtered_n` of this very moment (not pushed yet).
double sim_sensor_read(sim_sensor_t *sensor, double filtered_n);

#endif
