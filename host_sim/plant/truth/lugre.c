// LuGre: an average bristle with damping, Eq. (12) of the paper.
//
//     f = sat(s0 z + s1 dz/dt + s2 w, L)        dz/dt = w - s0 |w| z / g(w)
//     g(w) = r L + (1 - r) L exp(-(w / ws)^2)                                  L = L(F)
//
// With `stiffens` s0 and s1 are those of L = 1 N; s0 grows with L and s1 with its root, so that the travel to breakaway is
// the same at each load.
//
// Breakaway L, sliding friction r L (the paper: r = 1, F_C = F_S). Shows presliding, Stribeck effect (r < 1), friction
// lag and a breakaway that depends on the rate of force; drifts in presliding. With the paper's stiffness presliding is
// 1.6e-6 deg at 0.5 N and s1/I is 2.6e6 1/s: an explicit step must stay below 0.7 us. The fixed steps are implicit, two
// in one of the plant's for the stick-slip with r < 1.
//
// Source: C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, "A new model for control of systems with friction",
// IEEE Trans. Automatic Control 40(3), 1995; parameters and saturation: the paper's section 4.

#include "plant/truth/arm.h"
#include "plant/truth/stribeck.h"

#include <math.h>

typedef struct
{
    double s0, s1, s2;
    double sliding_ratio;
    double stribeck_speed;
    int    limited;  ///< 0 or 1
    int    stiffens; ///< 0 or 1
} lugre_t;

/// Returns the factor of the stiffness.
static double stiffer(const lugre_t *lugre, const sim_contact_t *contact, double z)
{
    return lugre->stiffens != 0 ? sim_law_breakaway(contact, z) : 1.0;
}

static double force(const lugre_t *lugre, const sim_contact_t *contact, double z, double dz, double w)
{
    const double times = stiffer(lugre, contact, z);
    const double f     = lugre->s0 * times * z + lugre->s1 * sqrt(times) * dz + lugre->s2 * w;
    return lugre->limited != 0 ? sim_law_limit(contact, f) : f;
}

static double level(const lugre_t *lugre, const sim_contact_t *contact, double w)
{
    return sim_stribeck(lugre->sliding_ratio, w, lugre->stribeck_speed) * sim_law_breakaway(contact, w);
}

/// Steps implicitly in the bristle and the speed; only g is taken at the start.
static double update(const void *law, const sim_law_step_t *step, double end_speed, double z_end[])
{
    const lugre_t *lugre = law;
    const double   x     = step->length_s * end_speed;
    const double   g     = level(lugre, &step->start, copysign(step->start.speed_deg_per_s, end_speed));
    const double   s0    = lugre->s0 * stiffer(lugre, &step->start, step->z[0]);
    z_end[0]             = (step->z[0] + x) / (1.0 + s0 * fabs(x) / g);
    return force(lugre, &step->start, z_end[0], (z_end[0] - step->z[0]) / step->length_s, end_speed);
}

static void rates(const void *law, const sim_contact_t *now, const double z[], double dz[])
{
    const lugre_t *lugre = law;
    const double   w     = now->speed_deg_per_s;
    const double   s0    = lugre->s0 * stiffer(lugre, now, z[0]);
    dz[0]                = w - s0 * fabs(w) * z[0] / level(lugre, now, w);
}

static double friction(const void *law, const sim_contact_t *now, const double z[])
{
    double dz;
    rates(law, now, z, &dz);
    return force(law, now, z[0], dz, now->speed_deg_per_s);
}

static const sim_law_t law = {.size        = sizeof(lugre_t),
                              .own_size    = sizeof(lugre_t),
                              .state_count = 1,
                              .turns       = true,
                              .steps       = 2,
                              .update      = update,
                              .friction    = friction,
                              .rates       = rates};

static const char *const no_or_yes[] = {"no", "yes", NULL};

// clang-format off: one row a key
static const common_key_t keys[] = {
    SIM_TRUTH_NUMBER(lugre_t, s0, "stiffness_N_per_deg", "N/deg", 1e-4, 1e7, 1e5, "s0: stiffness of the bristles"),
    SIM_TRUTH_NUMBER(lugre_t, s1, "bristle_damping_N_s_per_deg", "N s/deg", 0.0, 1e4, 316.22776601683796, "s1: damping of the bristles"),
    SIM_TRUTH_NUMBER(lugre_t, s2, "viscous_N_s_per_deg", "N s/deg", 0.0, 10.0, 0.4, "s2: damping of sliding, added to the arm's own"),
    SIM_STRIBECK_KEYS(lugre_t),
    SIM_TRUTH_CHOICE(lugre_t, limited, "limited", no_or_yes, 1, "whether f is limited to L: yes as in the paper, no as first published"),
    SIM_TRUTH_CHOICE(lugre_t, stiffens, "stiffens", no_or_yes, 0, "whether s0 grows with L, and s1 with its root; the given values are then those of L = 1 N"),
    SIM_TRUTH_END,
};
// clang-format on

SIM_ARM_TRUTH(lugre, law, keys);
