#include "own_plant.h"

#include <math.h>

#define STEPS           50
#define BRISTLES        800.0 // N/deg
#define BRISTLE_DAMPING 0.1   // N s/deg
#define ELEMENT_SHARE   (1.0 / OWN_PLANT_ELEMENTS)

own_plant_t own_plant(bool slips, double factor)
{
    return (own_plant_t){.slips         = slips,
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

void own_plant_step(own_plant_t *plant, double u_n)
{
    const double h = 1e-3 / STEPS;
    for (int i = 0; i < STEPS; i++)
    {
        const double force_n   = plant->stiffness * plant->angle_deg;
        const double most_n    = plant->offset_n + plant->slope * fabs(force_n);
        const double friction  = plant->slips ? maxwell(plant, most_n, h) : lugre(plant, most_n, h);
        const double net_n     = plant->drive_n - force_n - friction - plant->damping * plant->speed_deg_per_s;
        plant->speed_deg_per_s = plant->clamped ? 0.0 : plant->speed_deg_per_s + h * net_n / plant->inertia;
        plant->angle_deg += h * plant->speed_deg_per_s;
        plant->drive_n += h * plant->actuator_pole * (u_n - plant->drive_n);
        plant->filtered_n += h * plant->sensor_pole * (force_n - plant->filtered_n);
    }
}
