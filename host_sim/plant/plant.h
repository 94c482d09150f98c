/// Simulates the plant that the loop controls, in double precision:
///
///     u --> actuator --u_a--> truth model --F--> sensor filter --y--> sensor (sensor.h)
///           u_a' = p (u - u_a)  truth.h         y' = p (F - y)
///
/// A plant step passes the signal once, left to right: each part advances by its exact zero-order-hold solution, with its
/// input held at the new output of the part before. A drive force held over the step keeps a stuck arm from creeping.

#ifndef SIM_PLANT_H
#define SIM_PLANT_H

#include "plant/drive_error.h"
#include "plant/truth.h"

#include <stddef.h>

typedef struct
{
    double             step_s;
    double             actuator_pole_rad_per_s;
    double             sensor_pole_rad_per_s;
    sim_truth_config_t truth;
    sim_drive_error_t  drive_error; ///< all zeros: none
} sim_plant_config_t;

typedef struct sim_plant sim_plant_t;

/// The signals of one step.
typedef struct
{
    double              u_a_n; ///< the actuator's force on the arm, with its ripple
    sim_truth_signals_t truth;
} sim_plant_signals_t;

/// Creates a plant at rest; null if there is no memory. `config` must outlive it (its breakaway table is not copied).
sim_plant_t *sim_plant_create(const sim_plant_config_t *config, const sim_truth_ops_t *truth);
void         sim_plant_destroy(sim_plant_t *plant);

/// Advances one step of step_s with `u_n` held.
void sim_plant_step(sim_plant_t *plant, double u_n, sim_plant_signals_t *signals);

/// Return the present end-point force F, and F filtered by the sensor's pole, in N.
double sim_plant_force(const sim_plant_t *plant);
double sim_plant_filtered_force(const sim_plant_t *plant);

/// Save everything that a step changes as bytes, and load it from the bytes of a plant with the same config.
size_t sim_plant_size(const sim_plant_t *plant);
void   sim_plant_save(const sim_plant_t *plant, void *bytes);
void   sim_plant_load(sim_plant_t *plant, const void *bytes);

#endif
