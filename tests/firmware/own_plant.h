// An arm in contact that shares no code with host_sim, nor its way to integrate: semi-implicit Euler steps of 20 us. Its friction is LuGre,
// four Maxwell elements that slip one after the other, Coulomb's, or a servo's gears'. It can break, and a hand can push it.

#ifndef TESTS_FIRMWARE_OWN_PLANT_H
#define TESTS_FIRMWARE_OWN_PLANT_H

#include <stdbool.h>

#define OWN_PLANT_ELEMENTS 4

typedef enum
{
    OWN_PLANT_LUGRE,
    OWN_PLANT_MAXWELL,
    OWN_PLANT_COULOMB,
    OWN_PLANT_SERVO, // Coulomb's, a third more at rest, and half as much of the load where that drives the arm
    OWN_PLANT_FRICTIONS
} own_plant_friction_t;

typedef struct
{
    // the rig
    own_plant_friction_t friction;
    double               inertia, damping;           // N s^2/deg, N s/deg
    double               stiffness;                  // of the contact, N/deg; 0: it is lost
    double               offset_n, slope;            // L = offset + slope |F|
    double               actuator_pole, sensor_pole; // rad/s
    bool                 clamped;                    // the arm cannot move
    double               hand_n;                     // somebody pushes

    // its state
    double drive_n, angle_deg, speed_deg_per_s, filtered_n;
    double bristle_deg;
    double stretch_deg[OWN_PLANT_ELEMENTS];
} own_plant_t;

/// The paper's rig with breakaway times `factor`, at rest.
own_plant_t own_plant(own_plant_friction_t friction, double factor);

/// A time with `u_n` held.
void own_plant_step(own_plant_t *plant, double u_n, double time_s);

#endif
