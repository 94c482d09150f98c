// A force-controlled arm written for judging, sharing no code with host_sim: implicit steps of the arm with one of five frictions.
//
//     actuator  u_a' = p_a (u - u_a)
//     arm       (I/K) q'' + (b/K) q' + F = u_a + load - f(q'),     F = q - environment
//     sensor    y' = p_s (F - y), then noise
//
// All in force: q is the arm's position times its stiffness. f is set-valued at rest (Coulomb, Stribeck), a bristle (LuGre), four
// stops (Maxwell slip) or tanh(q'/creep), which creeps where the others stick; its level is L+ or L- = offset + slope |F|.

#ifndef TESTS_CLOSED_LOOP_FOREIGN_PLANT_H
#define TESTS_CLOSED_LOOP_FOREIGN_PLANT_H

#include <stdint.h>

#define FOREIGN_STOPS 4

typedef enum
{
    FOREIGN_COULOMB,
    FOREIGN_STRIBECK,
    FOREIGN_LUGRE,
    FOREIGN_MAXWELL,
    FOREIGN_SMOOTH,
    FOREIGN_LAWS
} foreign_law_t;

typedef struct
{
    double        actuator_pole, sensor_pole; // rad/s
    double        inertia, damping;           // I/K in s^2, b/K in s
    double        offset[2], slope[2];        // of L+ and L-
    foreign_law_t law;
    double        sliding;    // sliding level over breakaway, 1 without a peak
    double        stribeck;   // rate of q at which the peak has fallen to 1/e, N/s
    double        presliding; // travel of q until a bristle or the widest stop slides, N
    double        creep;      // rate of q that smooth friction has three quarters of its level at, N/s
    double        noise;      // standard deviation of y, N
    double        step_s;
} foreign_plant_config_t;

typedef struct
{
    foreign_plant_config_t config;
    double                 actuator_part, sensor_part; // of a low pass in a step
    double                 actuator, position, rate, environment, sensor;
    double                 bristle[FOREIGN_STOPS];
    double                 friction; // of the last step
    uint64_t               seed;
} foreign_plant_t;

void foreign_plant_open(foreign_plant_t *plant, const foreign_plant_config_t *config, uint64_t seed);

/// One step of `step_s` with input `u`, a load on the arm, and the environment's position times the stiffness.
void foreign_plant_step(foreign_plant_t *plant, double u, double load, double environment);

double foreign_plant_force(const foreign_plant_t *plant);

/// A reading with its noise.
double foreign_plant_read(foreign_plant_t *plant);

/// Uniform in -1 to 1.
double foreign_random(uint64_t *seed);

#endif
