/// The simulated joint for the C examples without a force sensor: 0.002 kg m2, sticks at 0.12 N m and slides at 0.1.
/// Positions are in turns, torques in N m.

#ifndef EXAMPLES_SIM_HINGE_H
#define EXAMPLES_SIM_HINGE_H

#include <math.h>

#define HINGE_INERTIA   0.0126 // N m s2 per turn
#define HINGE_FRICTION  0.1    // N m
#define HINGE_BREAKAWAY 0.12
#define HINGE_STRIBECK  0.02 // turns/s
#define HINGE_SUBSTEPS  20

typedef struct
{
    double angle, speed;
} hinge_t;

/// Advances the joint by one period with a constant torque.
static inline void hinge_step(hinge_t *hinge, double period_s, double torque)
{
    const double dt = period_s / HINGE_SUBSTEPS;
    for (int i = 0; i < HINGE_SUBSTEPS; i++)
    {
        const double held =
            HINGE_FRICTION + (HINGE_BREAKAWAY - HINGE_FRICTION) * exp(-fabs(hinge->speed) / HINGE_STRIBECK);
        const double push = torque + HINGE_INERTIA * hinge->speed / dt;
        hinge->speed      = fabs(push) < held ? 0.0 : (push - copysign(held, push)) * dt / HINGE_INERTIA;
        hinge->angle += dt * hinge->speed;
    }
}

/// Returns the reading, in turns, of an encoder with `counts` per turn.
static inline double hinge_reading(const hinge_t *hinge, double counts)
{
    return floor(hinge->angle * counts) / counts;
}

#endif
