// Leuven integrated model: LuGre's bristle with a hysteresis of presliding that has non-local memory.
//
//     f = Fh(z) + s1 dz/dt + s2 w        dz/dt = w (1 - sgn(w Fh) |Fh / s(w)|^n)
//     s(w) = r L + (1 - r) L exp(-(w / ws)^2)
//     Fh = L sum q_i:  dq_i/dt = k_i dz/dt while |q_i| < a_i; stays at a_i while z goes on in that direction;  sum a_i = 1
//
// Inner loops of f against position close and are forgotten; sliding friction is s(w). With r = 1 there is no drift until
// all elements yield.
//
// Source: J. Swevers, F. Al-Bender, C. G. Ganseman, T. Prajogo, "An integrated friction model structure with improved
// presliding behavior for accurate friction compensation", IEEE Trans. Automatic Control 45(4), 2000, as modified by
// V. Lampaert, J. Swevers, F. Al-Bender, "Modification of the Leuven integrated friction model structure", ibid. 47(4),
// 2002: continuous friction force, and Maxwell slip elements instead of a stack of reversals. Here an element's stiffness
// grows with its level, in proportion to L. Stiffness scaled as in dahl.c, damping to the arm's inertia on it.

#include "plant/truth/arm.h"
#include "plant/truth/stribeck.h"
#include "support/elementary.h"

#include <math.h>

#define ELEMENTS 4

/// Each element's fraction of breakaway and stiffness. The elements yield one after the other, the stiffest first.
static const double level_part[ELEMENTS]     = {0.1, 0.2, 0.3, 0.4};
static const double stiffness_part[ELEMENTS] = {0.4, 0.3, 0.2, 0.1};

typedef struct
{
    double distance;
    double damping;
    double viscous;
    double exponent;
    double sliding_ratio;
    double stribeck_speed;
} parameters_t;

typedef struct
{
    parameters_t p;
    int          way[ELEMENTS]; ///< direction in which the element has yielded, 0 while it is a spring
} leuven_t;

static double hysteresis(const sim_contact_t *contact, const double z[])
{
    double part = 0.0;
    for (int i = 0; i < ELEMENTS; i++)
    {
        part += z[i];
    }
    return sim_law_breakaway(contact, part) * part;
}

/// Returns dz/dt divided by w: 1 from rest, 0 once sliding has reached s(w), up to 2 after a reversal.
static double follow(const leuven_t *leuven, const sim_contact_t *contact, const double z[], double w, double way)
{
    const double fh = hysteresis(contact, z);
    const double s =
        sim_stribeck(leuven->p.sliding_ratio, w, leuven->p.stribeck_speed) * sim_law_breakaway(contact, fh);
    const double part = common_pow(fabs(fh) / s, leuven->p.exponent);
    return signbit(fh) == signbit(way) ? 1.0 - part : 1.0 + part;
}

static double update(const void *law, const sim_law_step_t *step, double end_speed, double z_end[])
{
    const leuven_t *leuven = law;
    const double    dz =
        step->length_s * end_speed * follow(leuven, &step->start, step->z, step->start.speed_deg_per_s, end_speed);
    for (int i = 0; i < ELEMENTS; i++)
    {
        const double spring = step->z[i] + stiffness_part[i] * dz / leuven->p.distance;
        z_end[i]            = fmin(level_part[i], fmax(-level_part[i], spring));
    }
    return hysteresis(&step->start, z_end) + leuven->p.damping * dz / step->length_s + leuven->p.viscous * end_speed;
}

static void rates(const void *law, const sim_contact_t *now, const double z[], double dz[])
{
    const leuven_t *leuven = law;
    const double    w      = now->speed_deg_per_s;
    const double    rate   = w * follow(leuven, now, z, w, w) / leuven->p.distance;
    for (int i = 0; i < ELEMENTS; i++)
    {
        dz[i] = leuven->way[i] != 0 ? 0.0 : stiffness_part[i] * rate;
    }
}

static double friction(const void *law, const sim_contact_t *now, const double z[])
{
    const leuven_t *leuven = law;
    const double    w      = now->speed_deg_per_s;
    return hysteresis(now, z) + (leuven->p.damping * follow(leuven, now, z, w, w) + leuven->p.viscous) * w;
}

#define GUARDS ELEMENTS

/// The guard is on dz/dt, not on w: with sliding friction below breakaway z can reverse while w does not. In sliding dz/dt
/// is 0 except for rounding.
static void guards(const void *law, const sim_contact_t *now, const double z[], double g[])
{
    const leuven_t *leuven = law;
    const double    w      = now->speed_deg_per_s;
    const double    rate   = w * follow(leuven, now, z, w, w);
    for (int i = 0; i < ELEMENTS; i++)
    {
        g[i] = leuven->way[i] != 0 ? leuven->way[i] * rate + SIM_LAW_TURN_DEG_PER_S : level_part[i] - fabs(z[i]);
    }
}

static void cross(void *law, sim_contact_t *now, double z[], unsigned guard)
{
    leuven_t *leuven = law;
    (void)now;
    if (leuven->way[guard] != 0)
    {
        leuven->way[guard] = 0;
        return;
    }
    leuven->way[guard] = z[guard] > 0.0 ? 1 : -1;
    z[guard]           = copysign(level_part[guard], z[guard]);
}

static const sim_law_t law = {.size        = sizeof(leuven_t),
                              .own_size    = sizeof(parameters_t),
                              .state_count = ELEMENTS,
                              .guard_count = GUARDS,
                              .update      = update,
                              .friction    = friction,
                              .rates       = rates,
                              .guards      = guards,
                              .cross       = cross};

// clang-format off: one row a key
static const common_key_t keys[] = {
    SIM_TRUTH_NUMBER(parameters_t, distance, "distance_deg", "deg", 1e-7, 1.0, 8e-4, "travel over which the stiffness at rest would reach breakaway"),
    SIM_TRUTH_NUMBER(parameters_t, damping, "bristle_damping_N_s_per_deg", "N s/deg", 0.0, 1e3, 0.3, "s1: damping of the bristles"),
    SIM_TRUTH_NUMBER(parameters_t, viscous, "viscous_N_s_per_deg", "N s/deg", 0.0, 10.0, 0.0, "s2, added to the arm's own"),
    SIM_TRUTH_NUMBER(parameters_t, exponent, "exponent", "-", 1.0, 20.0, 2.0, "n: how sharply sliding begins"),
    SIM_STRIBECK_KEYS(parameters_t),
    SIM_TRUTH_END,
};
// clang-format on

SIM_ARM_TRUTH(leuven, law, keys);
