// Lubricated contact (Harnoy and Friedland): a turning shaft in a short bearing rises on its film, which unloads the
// asperities.
//
//     film:       c J22(e) de/dt = W - contact(e) - c |w| e |J12(e)| / 2          e: eccentricity, 0 to 1
//     contact:    contact(e) = k (e - et) where e > et, 0 elsewhere
//     friction:   f = contact(e) z + cv w / sqrt(1 - e^2)        dz/dt = (w - |w| z) / d
//     J12 = 2 e / (1 - e^2)^2,    J22 = pi (1 + 2 e^2) / (2 (1 - e^2)^(5/2))
//
// Loads are in newtons of friction (coefficient 1), so W = L(F): at rest the asperities carry all and breakaway is L.
// Where L+ and L- differ, W is their mean, and the asperities carry the same fraction of each as of W.
// Sliding friction falls as the film lifts the shaft (Stribeck). It lags, because oil must be squeezed in and out
// (frictional memory: f is lower while w falls than while it rises).
//
// Source: A. Harnoy, B. Friedland, "Dynamic friction model of lubricated surfaces for precise motion control", Tribology
// Transactions 37(3), 1994, and A. Harnoy, Bearing Design in Machinery, 2003, Eqs. (15-8), (15-9) for the film of the
// short bearing. Reduced here to one state of the film: no mass of the shaft, line of centres along the load. The
// asperities' shear z, from -1 to 1, is Dahl's (dahl.c), with a stiffness proportional to their load. Scaled so that the
// film carries the whole load at about 0.4 deg/s.

#include "plant/truth/arm.h"

#include <math.h>

#define PI 3.14159265358979323846

typedef struct
{
    double distance;
    double film;
    double contact;
    double transition;
    double viscous;
} parameters_t;

enum
{
    SHEAR,       ///< z
    ECCENTRICITY ///< e
};

typedef struct
{
    parameters_t p;
    int          way;
    bool         touches; ///< the asperities touch; only the guard reads it
} lubricated_t;

/// Limits e, which cannot reach 1, where the film's stiffness is infinite; a solver's trial steps can.
#define ECCENTRICITY_MAX 0.999

static double carried(const lubricated_t *bearing, double e)
{
    return bearing->p.contact * fmax(0.0, e - bearing->p.transition);
}

static double load(const sim_contact_t *contact)
{
    return 0.5 * (contact->breakaway.positive_n + contact->breakaway.negative_n);
}

static void reset(void *law, const sim_truth_config_t *config, double z[])
{
    lubricated_t *bearing       = law;
    bearing->way                = 1;
    bearing->touches            = true;
    const sim_contact_t contact = {.breakaway = sim_breakaway_at(&config->friction.breakaway, 0.0)};
    z[ECCENTRICITY]             = bearing->p.transition + load(&contact) / bearing->p.contact;
}

/// Returns de/dt.
static double film_rate(const lubricated_t *bearing, const sim_contact_t *contact, double eccentricity, double w)
{
    const double e    = fmin(ECCENTRICITY_MAX, eccentricity);
    const double gap  = 1.0 - e * e;
    const double lift = bearing->p.film * fabs(w) * e * e / (gap * gap);
    const double j22  = 0.5 * PI * (1.0 + 2.0 * e * e) / (gap * gap * sqrt(gap));
    return (load(contact) - carried(bearing, e) - lift) / (bearing->p.film * j22);
}

static double force(const lubricated_t  *bearing,
                    const sim_contact_t *contact,
                    double               shear,
                    double               eccentricity,
                    double               w)
{
    const double e    = fmin(ECCENTRICITY_MAX, eccentricity);
    const double most = carried(bearing, e) * sim_law_breakaway(contact, shear) / load(contact);
    return most * shear + bearing->p.viscous * w / sqrt(1.0 - e * e);
}

/// The film is slow (0.1 s), so an explicit step suffices.
static double update(const void *law, const sim_law_step_t *step, double end_speed, double z_end[])
{
    const lubricated_t *bearing = law;
    const double        part    = step->length_s * end_speed / bearing->p.distance;
    z_end[ECCENTRICITY] =
        step->z[ECCENTRICITY] +
        step->length_s * film_rate(bearing, &step->start, step->z[ECCENTRICITY], step->start.speed_deg_per_s);
    z_end[SHEAR] = (step->z[SHEAR] + part) / (1.0 + fabs(part));
    return force(bearing, &step->start, z_end[SHEAR], z_end[ECCENTRICITY], end_speed);
}

static double friction(const void *law, const sim_contact_t *now, const double z[])
{
    return force(law, now, z[SHEAR], z[ECCENTRICITY], now->speed_deg_per_s);
}

static void rates(const void *law, const sim_contact_t *now, const double z[], double dz[])
{
    const lubricated_t *bearing = law;
    const double        w       = now->speed_deg_per_s;
    dz[SHEAR]                   = (w - fabs(w) * z[SHEAR]) / bearing->p.distance;
    dz[ECCENTRICITY]            = film_rate(bearing, now, z[ECCENTRICITY], w);
}

enum
{
    TURNS,
    TOUCHES,
    GUARDS
};

/// Nothing switches, but the integrator restarts at the kinks of |w| and of the asperities' load.
static void guards(const void *law, const sim_contact_t *now, const double z[], double g[])
{
    const lubricated_t *bearing = law;
    const double        depth   = z[ECCENTRICITY] - bearing->p.transition;
    g[TURNS]                    = bearing->way * now->speed_deg_per_s + SIM_LAW_TURN_DEG_PER_S;
    g[TOUCHES]                  = bearing->touches ? depth : -depth;
}

static void cross(void *law, sim_contact_t *now, double z[], unsigned guard)
{
    lubricated_t *bearing = law;
    (void)now;
    (void)z;
    bearing->way     = guard == TURNS ? -bearing->way : bearing->way;
    bearing->touches = guard == TOUCHES ? !bearing->touches : bearing->touches;
}

static const sim_law_t law = {.size        = sizeof(lubricated_t),
                              .own_size    = sizeof(parameters_t),
                              .state_count = 2,
                              .guard_count = GUARDS,
                              .reset       = reset,
                              .update      = update,
                              .friction    = friction,
                              .rates       = rates,
                              .guards      = guards,
                              .cross       = cross};

// clang-format off: one row a key
static const common_key_t keys[] = {
    SIM_TRUTH_NUMBER(parameters_t, distance, "distance_deg", "deg", 1e-7, 1.0, 8e-4, "d: travel over which the asperities shear"),
    SIM_TRUTH_NUMBER(parameters_t, film, "film_N_s_per_deg", "N s/deg", 1e-4, 100.0, 0.2, "c: load that the film carries, per speed"),
    SIM_TRUTH_NUMBER(parameters_t, contact, "contact_N", "N", 0.1, 1e4, 20.0, "k: load of the asperities, per compression"),
    SIM_TRUTH_NUMBER(parameters_t, transition, "transition", "-", 0.1, 0.95, 0.7, "et: eccentricity at which asperities touch"),
    SIM_TRUTH_NUMBER(parameters_t, viscous, "viscous_N_s_per_deg", "N s/deg", 0.0, 10.0, 0.01, "cv: shear of the film"),
    SIM_TRUTH_END,
};
// clang-format on

SIM_ARM_TRUTH(lubricated, law, keys);
