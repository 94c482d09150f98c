// Reset integrator: a bond stretches up to a length and then slips; it is stronger until it slips.
//
//     dz/dt = 0 where w > 0 and z >= z0, or w < 0 and z <= -z0;  w otherwise
//     f = (1 + a) k z + s1 dz/dt    while |z| < z0        (stiction)
//     f = k z0 sgn(w)               while it slips        (1 + a) k z0 = L(F)
//
// Presliding is a linear spring up to breakaway L, then friction falls at once to L / (1 + a). No memory beyond z.
//
// Source: D. A. Haessig, B. Friedland, "On the modeling and simulation of friction", ASME J. Dynamic Systems, Measurement,
// and Control 113(3), 1991. Length scaled to the stiffness in dahl.c, damping to the arm's inertia on it.

#include "plant/truth/arm.h"

#include <math.h>

typedef struct
{
    double length;
    double stiction;
    double damping;
} parameters_t;

typedef struct
{
    parameters_t p;
    int          way; ///< direction of slipping, 0 while the bond holds
} reset_integrator_t;

static double held(const reset_integrator_t *bond, const sim_contact_t *contact, double z, double dz)
{
    return sim_law_breakaway(contact, z) * z / bond->p.length + bond->p.damping * dz;
}

static double slipping(const reset_integrator_t *bond, const sim_contact_t *contact)
{
    return bond->way * sim_law_breakaway(contact, bond->way) / (1.0 + bond->p.stiction);
}

/// A bond that reaches its length in this step slips from the next step on.
static double update(const void *law, const sim_law_step_t *step, double end_speed, double z_end[])
{
    const reset_integrator_t *bond = law;
    if (bond->way != 0 && (signbit(end_speed) != 0) == (bond->way < 0))
    {
        z_end[0] = step->z[0];
        return slipping(bond, &step->start);
    }
    const double stretched = step->z[0] + step->length_s * end_speed;
    z_end[0]               = fmin(bond->p.length, fmax(-bond->p.length, stretched));
    return held(bond, &step->start, z_end[0], (z_end[0] - step->z[0]) / step->length_s);
}

static void settle(void *law, const sim_contact_t *end, double z[])
{
    reset_integrator_t *bond = law;
    const double        w    = end->speed_deg_per_s;
    bond->way                = (z[0] >= bond->p.length && w > 0.0) ? 1 : (z[0] <= -bond->p.length && w < 0.0) ? -1 : 0;
}

static void rates(const void *law, const sim_contact_t *now, const double z[], double dz[])
{
    (void)z;
    dz[0] = ((const reset_integrator_t *)law)->way != 0 ? 0.0 : now->speed_deg_per_s;
}

static double friction(const void *law, const sim_contact_t *now, const double z[])
{
    const reset_integrator_t *bond = law;
    return bond->way != 0 ? slipping(bond, now) : held(bond, now, z[0], now->speed_deg_per_s);
}

enum
{
    HOLDS_OR_SLIPS_UP,
    SLIPS_DOWN,
    GUARDS
};

static void guards(const void *law, const sim_contact_t *now, const double z[], double g[])
{
    const reset_integrator_t *bond = law;
    g[HOLDS_OR_SLIPS_UP]           = bond->way != 0 ? bond->way * now->speed_deg_per_s : bond->p.length - z[0];
    g[SLIPS_DOWN]                  = bond->way != 0 ? 1.0 : bond->p.length + z[0];
}

static void cross(void *law, sim_contact_t *now, double z[], unsigned guard)
{
    reset_integrator_t *bond = law;
    (void)now;
    bond->way = bond->way != 0 ? 0 : guard == SLIPS_DOWN ? -1 : 1;
    z[0]      = copysign(bond->p.length, z[0]);
}

static const sim_law_t law = {.size        = sizeof(reset_integrator_t),
                              .own_size    = sizeof(parameters_t),
                              .state_count = 1,
                              .guard_count = GUARDS,
                              .update      = update,
                              .settle      = settle,
                              .friction    = friction,
                              .rates       = rates,
                              .guards      = guards,
                              .cross       = cross};

// clang-format off: one row a key
static const common_key_t keys[] = {
    SIM_TRUTH_NUMBER(parameters_t, length, "length_deg", "deg", 1e-7, 1.0, 8e-4, "z0: stretch at which the bond slips"),
    SIM_TRUTH_NUMBER(parameters_t, stiction, "stiction", "-", 0.0, 2.0, 0.05, "a: breakaway divided by friction of slipping, minus 1"),
    SIM_TRUTH_NUMBER(parameters_t, damping, "damping_N_s_per_deg", "N s/deg", 0.0, 1e3, 0.3, "s1: damping while the bond holds"),
    SIM_TRUTH_END,
};
// clang-format on

SIM_ARM_TRUTH(reset_integrator, law, keys);
