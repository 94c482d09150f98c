// Generalised Maxwell slip: elements in parallel. Each sticks as a spring or slips towards its fraction of the Stribeck
// curve.
//
//     sticks:  dF_i/dt = k_i w                                   until |F_i| = a_i s(w)
//     slips:   dF_i/dt = sgn(w) C (a_i - |F_i| / s(w))           until w turns
//     f = sum F_i + s2 w,    s(w) = r L + (1 - r) L exp(-(w / ws)^2),   sum a_i = 1
//
// With `stiffens` k_i is that of L = 1 N and grows with L, so that the travel to breakaway is the same at each load. a_i is
// proportional to i^p, and k_i to a_i, so that the travel after which an element yields does not depend on p. Below p = 1
// more of L acts after little travel.
//
// Presliding is hysteresis with non-local memory: an inner loop closes and is forgotten (Masing's rules). C sets the
// friction lag. No drift.
//
// Source: V. Lampaert, F. Al-Bender, J. Swevers, "A generalized Maxwell-slip friction model appropriate for control
// purposes", IEEE Physics and Control, 2003; F. Al-Bender, V. Lampaert, J. Swevers, "The generalized Maxwell-slip model",
// IEEE Trans. Automatic Control 50(11), 2005. Stiffness scaled as in dahl.c.

#include "plant/truth/arm.h"
#include "plant/truth/stribeck.h"

#include <math.h>

#define ELEMENTS 4

/// Each element's fraction of breakaway and stiffness at p = 1. The elements yield one after the other, the stiffest first.
static const double level_part[ELEMENTS]     = {0.1, 0.2, 0.3, 0.4};
static const double stiffness_part[ELEMENTS] = {0.4, 0.3, 0.2, 0.1};

typedef struct
{
    double stiffness;
    double attraction;
    double viscous;
    double sliding_ratio;
    double stribeck_speed;
    double exponent;
    int    stiffens; ///< 0 or 1
} parameters_t;

typedef struct
{
    parameters_t p;
    double       level_part[ELEMENTS];
    double       stiffness_part[ELEMENTS];
    int          way[ELEMENTS]; ///< direction of slip, 0 while the element sticks
} maxwell_slip_t;

static void share(maxwell_slip_t *maxwell)
{
    double part[ELEMENTS];
    double sum = 0.0;
    for (int i = 0; i < ELEMENTS; i++)
    {
        part[i] = common_pow(level_part[i], maxwell->p.exponent);
        sum += part[i];
    }
    for (int i = 0; i < ELEMENTS; i++)
    {
        const double times         = maxwell->p.exponent == 1.0 ? 1.0 : part[i] / sum / level_part[i];
        maxwell->level_part[i]     = times * level_part[i];
        maxwell->stiffness_part[i] = times * stiffness_part[i];
    }
}

static void reset(void *law, const sim_truth_config_t *config, double z[])
{
    (void)config;
    (void)z;
    share(law);
}

/// Returns s for the sign `side`, at speed w.
static double level(const maxwell_slip_t *maxwell, const sim_contact_t *contact, double side, double w)
{
    return sim_stribeck(maxwell->p.sliding_ratio, w, maxwell->p.stribeck_speed) * sim_law_breakaway(contact, side);
}

/// Returns the level of the i-th element.
static double stiffness(const maxwell_slip_t *maxwell, const sim_contact_t *contact, double z, int i)
{
    return maxwell->stiffness_part[i] * maxwell->p.stiffness *
           (maxwell->p.stiffens != 0 ? sim_law_breakaway(contact, z) : 1.0);
}

static double update(const void *law, const sim_law_step_t *step, double end_speed, double z_end[])
{
    const maxwell_slip_t *maxwell = law;
    const double          pull    = maxwell->p.attraction * step->length_s;

    double f = maxwell->p.viscous * end_speed;
    for (int i = 0; i < ELEMENTS; i++)
    {
        const int way = maxwell->way[i];
        if (way != 0 && (signbit(end_speed) != 0) == (way < 0))
        {
            const double s = level(maxwell, &step->start, way, step->start.speed_deg_per_s);
            z_end[i]       = (step->z[i] + pull * maxwell->level_part[i] * way) / (1.0 + pull / s);
        }
        else
        {
            const double up = maxwell->level_part[i] * level(maxwell, &step->start, 1.0, step->start.speed_deg_per_s);
            const double down =
                maxwell->level_part[i] * level(maxwell, &step->start, -1.0, step->start.speed_deg_per_s);
            const double spring =
                step->z[i] + stiffness(maxwell, &step->start, step->z[i], i) * step->length_s * end_speed;
            // The element is already beyond its level, because the level has fallen. It stays there until it slips.
            z_end[i] = fmin(fmax(up, step->z[i]), fmax(fmin(-down, step->z[i]), spring));
        }
        f += z_end[i];
    }
    return f;
}

static void settle(void *law, const sim_contact_t *end, double z[])
{
    maxwell_slip_t *maxwell = law;
    const double    w       = end->speed_deg_per_s;
    const int       way     = w > 0.0 ? 1 : w < 0.0 ? -1 : 0;
    for (int i = 0; i < ELEMENTS; i++)
    {
        const bool slips = maxwell->way[i] != 0 ? maxwell->way[i] == way
                                                : way * z[i] >= maxwell->level_part[i] * level(maxwell, end, way, w);
        maxwell->way[i]  = slips ? way : 0;
    }
}

static double friction(const void *law, const sim_contact_t *now, const double z[])
{
    double f = ((const maxwell_slip_t *)law)->p.viscous * now->speed_deg_per_s;
    for (int i = 0; i < ELEMENTS; i++)
    {
        f += z[i];
    }
    return f;
}

static void rates(const void *law, const sim_contact_t *now, const double z[], double dz[])
{
    const maxwell_slip_t *maxwell = law;
    const double          w       = now->speed_deg_per_s;
    for (int i = 0; i < ELEMENTS; i++)
    {
        const int way = maxwell->way[i];
        dz[i]         = way == 0 ? stiffness(maxwell, now, z[i], i) * w
                                 : maxwell->p.attraction * (maxwell->level_part[i] * way - z[i] / level(maxwell, now, way, w));
    }
}

#define GUARDS ELEMENTS

/// A stuck element may exceed its level, which falls with speed, while the motion unloads it.
static void guards(const void *law, const sim_contact_t *now, const double z[], double g[])
{
    const maxwell_slip_t *maxwell = law;
    const double          w       = now->speed_deg_per_s;
    for (int i = 0; i < ELEMENTS; i++)
    {
        const double room      = maxwell->level_part[i] * level(maxwell, now, z[i], w) - fabs(z[i]);
        const double unloading = -copysign(1.0, z[i]) * w;
        g[i]                   = maxwell->way[i] != 0 ? maxwell->way[i] * w : fmax(room, unloading);
    }
}

static void cross(void *law, sim_contact_t *now, double z[], unsigned guard)
{
    maxwell_slip_t *maxwell = law;
    (void)now;
    maxwell->way[guard] = maxwell->way[guard] != 0 ? 0 : z[guard] > 0.0 ? 1 : -1;
}

static const sim_law_t law = {.size        = sizeof(maxwell_slip_t),
                              .own_size    = sizeof(parameters_t),
                              .state_count = ELEMENTS,
                              .guard_count = GUARDS,
                              .reset       = reset,
                              .update      = update,
                              .settle      = settle,
                              .friction    = friction,
                              .rates       = rates,
                              .guards      = guards,
                              .cross       = cross};

static const char *const no_or_yes[] = {"no", "yes", NULL};

// clang-format off: one row a key
static const common_key_t keys[] = {
    SIM_TRUTH_NUMBER(parameters_t, stiffness, "stiffness_N_per_deg", "N/deg", 1e-4, 1e6, 200.0, "stiffness of all elements together, at an exponent of 1"),
    SIM_TRUTH_NUMBER(parameters_t, attraction, "attraction_N_per_s", "N/s", 0.1, 1e6, 80.0, "C: rate at which a slipping element approaches its level"),
    SIM_TRUTH_NUMBER(parameters_t, viscous, "viscous_N_s_per_deg", "N s/deg", 0.0, 10.0, 0.0, "s2, added to the arm's own"),
    SIM_STRIBECK_KEYS(parameters_t),
    SIM_TRUTH_NUMBER(parameters_t, exponent, "exponent", "-", -2.0, 2.0, 1.0, "p: the elements' parts of L are proportional to 1, 2, 3, 4 to this power; below 1 more of L acts after little travel"),
    SIM_TRUTH_CHOICE(parameters_t, stiffens, "stiffens", no_or_yes, 0, "whether the stiffness grows with L; the given value is then that of L = 1 N"),
    SIM_TRUTH_END,
};
// clang-format on

SIM_ARM_TRUTH(maxwell_slip, law, keys);
