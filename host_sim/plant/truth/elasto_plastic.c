// Elasto-plastic: LuGre's bristle, which yields only beyond a deflection, so that presliding below it is elastic.
//
//     f = s0 z + s1 dz/dt + s2 w        dz/dt = w - a(z, w) s0 |w| z / g(w)        z_max = g(w) / s0
//     a = 0 for |z| <= e z_max or z against w;  1 for |z| >= z_max;
//         1/2 + 1/2 sin(pi (|z| - (1 + e) z_max / 2) / ((1 - e) z_max)) between
//
// Unlike Dahl and LuGre it has stiction: no drift in presliding for oscillations below e L.
// g(w) and breakaway as in lugre.c.
//
// Source: P. Dupont, V. Hayward, B. Armstrong, F. Altpeter, "Single state elastoplastic friction models", IEEE Trans.
// Automatic Control 47(5), 2002. Stiffness scaled as in dahl.c, bristle damping to the arm's inertia on it.

#include "plant/truth/arm.h"
#include "plant/truth/stribeck.h"
#include "support/elementary.h"

#include <math.h>

#define PI 3.14159265358979323846

typedef struct
{
    double s0, s1, s2;
    double elastic_ratio;
    double sliding_ratio;
    double stribeck_speed;
} elasto_plastic_t;

/// Returns a(z, w), with deflections as fractions of z_max.
static double yielding(const elasto_plastic_t *plastic, double part, double w)
{
    const double elastic = plastic->elastic_ratio;
    const double along   = signbit(w) ? -part : part;
    if (along <= elastic)
    {
        return 0.0;
    }
    return along >= 1.0 ? 1.0 : 0.5 + 0.5 * common_sin(PI * (along - 0.5 * (1.0 + elastic)) / (1.0 - elastic));
}

static double level(const elasto_plastic_t *plastic, const sim_contact_t *contact, double w)
{
    return sim_stribeck(plastic->sliding_ratio, w, plastic->stribeck_speed) * sim_law_breakaway(contact, w);
}

static double force(const elasto_plastic_t *plastic, double z, double dz, double w)
{
    return plastic->s0 * z + plastic->s1 * dz + plastic->s2 * w;
}

static double update(const void *law, const sim_law_step_t *step, double end_speed, double z_end[])
{
    const elasto_plastic_t *plastic = law;
    const double            x       = step->length_s * end_speed;
    const double slope = plastic->s0 / level(plastic, &step->start, copysign(step->start.speed_deg_per_s, end_speed));
    // Use a at the start first, then the mean of start and end.
    const double at_start = slope * fabs(x) * yielding(plastic, slope * step->z[0], end_speed);
    const double middle   = 0.5 * (step->z[0] + (step->z[0] + x) / (1.0 + at_start));
    z_end[0]              = (step->z[0] + x) / (1.0 + slope * fabs(x) * yielding(plastic, slope * middle, end_speed));
    return force(plastic, z_end[0], (z_end[0] - step->z[0]) / step->length_s, end_speed);
}

static void rates(const void *law, const sim_contact_t *now, const double z[], double dz[])
{
    const elasto_plastic_t *plastic = law;
    const double            w       = now->speed_deg_per_s;
    const double            part    = plastic->s0 * z[0] / level(plastic, now, w);
    dz[0]                           = w - yielding(plastic, part, w) * fabs(w) * part;
}

static double friction(const void *law, const sim_contact_t *now, const double z[])
{
    double dz;
    rates(law, now, z, &dz);
    return force(law, z[0], dz, now->speed_deg_per_s);
}

static const sim_law_t law = {.size        = sizeof(elasto_plastic_t),
                              .own_size    = sizeof(elasto_plastic_t),
                              .state_count = 1,
                              .turns       = true,
                              .update      = update,
                              .friction    = friction,
                              .rates       = rates};

// clang-format off: one row a key
static const common_key_t keys[] = {
    SIM_TRUTH_NUMBER(elasto_plastic_t, s0, "stiffness_N_per_deg", "N/deg", 1.0, 1e6, 200.0, "s0: stiffness of the bristles"),
    SIM_TRUTH_NUMBER(elasto_plastic_t, s1, "bristle_damping_N_s_per_deg", "N s/deg", 0.0, 1e3, 0.3, "s1: damping of the bristles"),
    SIM_TRUTH_NUMBER(elasto_plastic_t, s2, "viscous_N_s_per_deg", "N s/deg", 0.0, 10.0, 0.0, "s2, added to the arm's own"),
    SIM_TRUTH_NUMBER(elasto_plastic_t, elastic_ratio, "elastic_ratio", "-", 0.0, 0.99, 0.85, "e: below this part of breakaway presliding is elastic"),
    SIM_STRIBECK_KEYS(elasto_plastic_t),
    SIM_TRUTH_END,
};
// clang-format on

SIM_ARM_TRUTH(elasto_plastic, law, keys);
