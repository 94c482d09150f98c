// Bristles: many bonds at random places. Each snaps at a deflection and bonds again elsewhere.
//
//     f = s sum (x - b_i) + s1 w,  i = 1 .. 20      |x - b_i| = d: the bond snaps, and x - b_i = d u sgn(x - b_i), u random
//
// u is uniform in 0 to 1. Sliding friction is noisy, r L(F) on average: s = 1.5 r L / (20 d), because a bond's deflection is
// 2/3 d on average. A slowly driven arm waits at the peaks of this noise; with r = 0.85 it takes about L to move it. The
// bonds depend on the path and the seed alone: rate independent except for s1.
//
// The published model has no damping (its authors note that it rings). Here each snap would then set off others by chance,
// and no two solvers agree for long. s1 is the arm's critical damping on its bonds. Snaps happen at the end of a step,
// hence twenty steps in one of the plant's.
//
// Source: D. A. Haessig, B. Friedland, "On the modeling and simulation of friction", ASME J. Dynamic Systems, Measurement,
// and Control 113(3), 1991, who take 20 to 25 bristles. Deflection scaled to the stiffness in dahl.c.

#include "plant/truth/arm.h"

#include "plant/random.h"

#include <math.h>

#define BRISTLES 20

typedef struct
{
    double   deflection;
    double   sliding_ratio;
    double   damping;
    uint64_t seed;
} parameters_t;

typedef struct
{
    parameters_t p;
    double       origin[BRISTLES];     ///< b, where x is the path from the start
    double       sum, lowest, highest; ///< sum and range of the origins
    sim_random_t random[BRISTLES];     ///< one for each bristle, so that the order of snaps in a step does not matter
} bristle_t;

static void sum_up(bristle_t *bristle)
{
    bristle->sum     = 0.0;
    bristle->lowest  = bristle->origin[0];
    bristle->highest = bristle->origin[0];
    for (int i = 0; i < BRISTLES; i++)
    {
        bristle->sum += bristle->origin[i];
        bristle->lowest  = fmin(bristle->lowest, bristle->origin[i]);
        bristle->highest = fmax(bristle->highest, bristle->origin[i]);
    }
}

static void reset(void *law, const sim_truth_config_t *config, double z[])
{
    bristle_t *bristle = law;
    (void)config;
    (void)z;
    for (int i = 0; i < BRISTLES; i++)
    {
        // The origins are balanced and spread evenly, so that the bonds do not all snap at once.
        bristle->origin[i] = bristle->p.deflection * (BRISTLES - 1 - 2 * i) / BRISTLES;
        sim_random_seed(&bristle->random[i], bristle->p.seed * BRISTLES + (uint64_t)i);
    }
    sum_up(bristle);
}

static double force(const bristle_t *bristle, const sim_contact_t *contact, double x, double w)
{
    const double sum   = BRISTLES * x - bristle->sum;
    const double level = bristle->p.sliding_ratio * sim_law_breakaway(contact, sum);
    return 1.5 * level * sum / (BRISTLES * bristle->p.deflection) + bristle->p.damping * w;
}

/// Snaps happen at the end of the step.
static double update(const void *law, const sim_law_step_t *step, double end_speed, double z_end[])
{
    z_end[0] = step->z[0] + step->length_s * end_speed;
    return force(law, &step->start, z_end[0], end_speed);
}

/// Snaps a bond at the exact place where its deflection was reached, so that the bonds depend only on the path.
static void snap(bristle_t *bristle, int i, double x)
{
    const double part = (double)(sim_random_bits(&bristle->random[i]) >> 11) * 0x1p-53;
    bristle->origin[i] += copysign((1.0 - part) * bristle->p.deflection, x - bristle->origin[i]);
}

static void settle(void *law, const sim_contact_t *end, double z[])
{
    bristle_t *bristle = law;
    (void)end;
    if (z[0] - bristle->lowest < bristle->p.deflection && bristle->highest - z[0] < bristle->p.deflection)
    {
        return;
    }
    for (int i = 0; i < BRISTLES; i++)
    {
        while (fabs(z[0] - bristle->origin[i]) >= bristle->p.deflection)
        {
            snap(bristle, i, z[0]);
        }
    }
    sum_up(bristle);
}

static double friction(const void *law, const sim_contact_t *now, const double z[])
{
    return force(law, now, z[0], now->speed_deg_per_s);
}

static void rates(const void *law, const sim_contact_t *now, const double z[], double dz[])
{
    (void)law;
    (void)z;
    dz[0] = now->speed_deg_per_s;
}

#define GUARDS BRISTLES

static void guards(const void *law, const sim_contact_t *now, const double z[], double g[])
{
    const bristle_t *bristle = law;
    (void)now;
    for (int i = 0; i < BRISTLES; i++)
    {
        g[i] = bristle->p.deflection - fabs(z[0] - bristle->origin[i]);
    }
}

static void cross(void *law, sim_contact_t *now, double z[], unsigned guard)
{
    (void)now;
    snap(law, (int)guard, z[0]);
    sum_up(law);
}

static const sim_law_t law = {.size        = sizeof(bristle_t),
                              .own_size    = sizeof(parameters_t),
                              .state_count = 1,
                              .guard_count = GUARDS,
                              .steps       = 20,
                              .reset       = reset,
                              .update      = update,
                              .settle      = settle,
                              .friction    = friction,
                              .rates       = rates,
                              .guards      = guards,
                              .cross       = cross};

// clang-format off: one row a key
static const common_key_t keys[] = {
    SIM_TRUTH_NUMBER(parameters_t, deflection, "deflection_deg", "deg", 1e-7, 1.0, 1.2e-3, "d: deflection at which a bond snaps"),
    SIM_TRUTH_NUMBER(parameters_t, sliding_ratio, "sliding_ratio", "-", 0.1, 1.0, 0.85, "r: mean friction along a path divided by L"),
    SIM_TRUTH_NUMBER(parameters_t, damping, "damping_N_s_per_deg", "N s/deg", 0.0, 1e3, 0.3, "s1: damping of the bonds"),
    SIM_TRUTH_WHOLE(parameters_t, seed, "seed", 0.0, 18446744073709551615.0, 1.0, "seed of the random places"),
    SIM_TRUTH_END,
};
// clang-format on

SIM_ARM_TRUTH(bristle, law, keys);
