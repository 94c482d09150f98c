// An arm in contact that shares no code with host_sim, nor its way to integrate: 50 semi-implicit Euler steps a millisecond. Its friction is
// LuGre, or four Maxwell elements that slip one after the other. It can break.

#ifndef TESTS_FIRMWARE_OWN_PLANT_H
#define TESTS_FIRMWARE_OWN_PLANT_H

#include <stdbool.h>

#define OWN_PLANT_ELEMENTS 4

typedef struct
{
    // the rig
    bool   slips;                      // Maxwell elements in place of LuGre
    double inertia, damping;           // N s^2/deg, N s/deg
    double stiffness;                  // of the contact, N/deg; 0: it is lost
    double offset_n, slope;            // L = offset + slope |F|
    double actuator_pole, sensor_pole; // rad/s
    bool   clamped;                    // the arm cannot move

    // its state
    double drive_n, angle_deg, speed_deg_per_s, filtered_n;
    double bristle_deg;
    double stretch_deg[OWN_PLANT_ELEMENTS];
} own_plant_t;

/// The paper's rig with breakaway times `factor`, at rest.
own_plant_t own_plant(bool slips, double factor);

/// A millisecond with `u_n` held.
void own_plant_step(own_plant_t *plant, double u_n);

#endif
