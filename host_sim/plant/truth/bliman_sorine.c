// Bliman and Sorine, second order: friction is a linear filter of the direction of motion along the path.
//
//     s = integral |w| dt        df1/ds = -f1 / (h e) + c1 L sgn(w) / (h e)        df2/ds = -f2 / e - c2 L sgn(w) / e
//     f = f1 + f2,  h < 1:  the slower one has the opposite sign, so f overshoots to breakaway L and falls to (c1 - c2) L
//
// c1 is chosen so that the peak is L; c2 = r c1. Rate independent, yet with a breakaway peak: the Stribeck effect depends on
// distance, not on speed. With r = 0 it is Dahl's model.
//
// Source: P.-A. Bliman, M. Sorine, "Easy-to-use realistic dry friction models for automatic control", European Control
// Conference, 1995; here with a load-dependent L, f1 and f2 as fractions of it. Distance scaled to the stiffness in dahl.c.

#include "plant/truth/arm.h"
#include "support/elementary.h"

#include <math.h>

typedef struct
{
    double distance;
    double fast_ratio;
    double slow_share;
} parameters_t;

typedef struct
{
    parameters_t p;
    double       c1, c2;
} bliman_sorine_t;

/// Returns the highest f1 + f2 along a path from rest, with c1 = 1.
static double peak(const parameters_t *p)
{
    if (p->slow_share == 0.0)
    {
        return 1.0;
    }
    const double path = p->fast_ratio / (1.0 - p->fast_ratio) * common_log(1.0 / (p->fast_ratio * p->slow_share));
    return -common_expm1(-path / p->fast_ratio) + p->slow_share * common_expm1(-path);
}

static void reset(void *law, const sim_truth_config_t *config, double z[])
{
    bliman_sorine_t *sorine = law;
    (void)config;
    (void)z;
    sorine->c1 = 1.0 / peak(&sorine->p);
    sorine->c2 = sorine->p.slow_share * sorine->c1;
}

static double friction(const void *law, const sim_contact_t *now, const double z[])
{
    (void)law;
    const double f = z[0] + z[1];
    return f * sim_law_breakaway(now, f);
}

static double update(const void *law, const sim_law_step_t *step, double end_speed, double z_end[])
{
    const bliman_sorine_t *sorine = law;
    const double           slow   = step->length_s * end_speed / sorine->p.distance;
    const double           fast   = slow / sorine->p.fast_ratio;
    z_end[0]                      = (step->z[0] + fast * sorine->c1) / (1.0 + fabs(fast));
    z_end[1]                      = (step->z[1] - slow * sorine->c2) / (1.0 + fabs(slow));
    return friction(law, &step->start, z_end);
}

static void rates(const void *law, const sim_contact_t *now, const double z[], double dz[])
{
    const bliman_sorine_t *sorine = law;
    const double           slow   = now->speed_deg_per_s / sorine->p.distance;
    const double           fast   = slow / sorine->p.fast_ratio;
    dz[0]                         = fast * sorine->c1 - fabs(fast) * z[0];
    dz[1]                         = -slow * sorine->c2 - fabs(slow) * z[1];
}

static const sim_law_t law = {.size        = sizeof(bliman_sorine_t),
                              .own_size    = sizeof(parameters_t),
                              .state_count = 2,
                              .turns       = true,
                              .reset       = reset,
                              .update      = update,
                              .friction    = friction,
                              .rates       = rates};

// clang-format off: one row a key
static const common_key_t keys[] = {
    SIM_TRUTH_NUMBER(parameters_t, distance, "distance_deg", "deg", 1e-6, 10.0, 0.003, "e: path over which the peak is forgotten"),
    SIM_TRUTH_NUMBER(parameters_t, fast_ratio, "fast_ratio", "-", 0.01, 0.9, 0.3, "h: distance of the rise divided by that of the fall"),
    SIM_TRUTH_NUMBER(parameters_t, slow_share, "slow_share", "-", 0.0, 0.9, 0.2, "r: sliding friction falls to (1 - r) times the peak; 0: no peak"),
    SIM_TRUTH_END,
};
// clang-format on

SIM_ARM_TRUTH(bliman_sorine, law, keys);
