#include "own_plant.h"

#include <math.h>

#define STEP_S          2e-5
#define BRISTLES        800.0 // N/deg
#define BRISTLE_DAMPING 0.1   // N s/deg
#define ELEMENT_SHARE   (1.0 / OWN_PLANT_ELEMENTS)

own_plant_t own_plant(own_plant_friction_t friction, double factor)
{
    return (own_plant_t){.friction      = friction,
                         .inertia       = 1.2e-4,
                         .damping       = 0.0288,
                         .stiffness     = 3.84,
                         .offset_n      = 0.007 * factor,
                         .slope         = 0.3 * factor,
                         .actuator_pole = 200.0,
                         .sensor_pole   = 55.0};
}

static double limit(double x, double most)
{
    return x > most ? most : x < -most ? -most : x;
}

/// The bristles follow the arm until they carry L.
static double lugre(own_plant_t *plant, double most_n, double h)
{
    const double v     = plant->speed_deg_per_s;
    const double bent  = most_n / BRISTLES;
    const double rate  = v - fabs(v) * plant->bristle_deg / bent;
    plant->bristle_deg = limit(plant->bristle_deg + h * rate, bent);
    return BRISTLES * plant->bristle_deg + BRISTLE_DAMPING * rate;
}

/// Each element carries a quarter of L, and the softer it is the later it slips.
static double maxwell(own_plant_t *plant, double most_n, double h)
{
    double sum_n = 0.0;
    for (int i = 0; i < OWN_PLANT_ELEMENTS; i++)
    {
        const double stiffness = BRISTLES * ELEMENT_SHARE / (1.0 + 2.0 * i);
        plant->stretch_deg[i] =
            limit(plant->stretch_deg[i] + h * plant->speed_deg_per_s, ELEMENT_SHARE * most_n / stiffness);
        sum_n += stiffness * plant->stretch_deg[i];
    }
    return sum_n;
}

/// Stands as long as friction holds it. Returns the new speed.
static double rub(const own_plant_t *plant, double net_n, double most_n, double h)
{
    const double v    = plant->speed_deg_per_s;
    const double sign = v > 0.0 || (v == 0.0 && net_n > 0.0) ? 1.0 : -1.0;
    if (v == 0.0 && fabs(net_n) <= most_n)
    {
        return 0.0;
    }
    const double next = v + h * (net_n - sign * most_n) / plant->inertia;
    return next * sign < 0.0 ? 0.0 : next;
}

static double of_gears(const own_plant_t *plant, double force_n)
{
    const double v      = plant->speed_deg_per_s;
    const double driven = force_n * v < 0.0 ? 0.5 : 1.0;
    return (plant->offset_n + driven * plant->slope * fabs(force_n)) * (1.0 + 0.33 * exp(-v * v));
}

static void step(own_plant_t *plant, double u_n, double h)
{
    const double force_n = plant->stiffness * plant->angle_deg;
    const double most_n  = plant->offset_n + plant->slope * fabs(force_n);
    const double net_n   = plant->drive_n + plant->hand_n - force_n - plant->damping * plant->speed_deg_per_s;
    double       speed   = 0.0;
    switch (plant->friction)
    {
    case OWN_PLANT_COULOMB:
        speed = rub(plant, net_n, most_n, h);
        break;
    case OWN_PLANT_SERVO:
        speed = rub(plant, net_n, of_gears(plant, force_n), h);
        break;
    case OWN_PLANT_MAXWELL:
        speed = plant->speed_deg_per_s + h * (net_n - maxwell(plant, most_n, h)) / plant->inertia;
        break;
    default:
        speed = plant->speed_deg_per_s + h * (net_n - lugre(plant, most_n, h)) / plant->inertia;
    }
    plant->speed_deg_per_s = plant->clamped ? 0.0 : speed;
    plant->angle_deg += h * plant->speed_deg_per_s;
    plant->drive_n += h * plant->actuator_pole * (u_n - plant->drive_n);
    plant->filtered_n += h * plant->sensor_pole * (force_n - plant->filtered_n);
}

void own_plant_step(own_plant_t *plant, double u_n, double time_s)
{
    const int steps = (int)(time_s / STEP_S + 0.5);
    for (int i = 0; i < steps; i++)
    {
        step(plant, u_n, time_s / steps);
    }
}
