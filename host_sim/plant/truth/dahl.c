// Dahl: the contact is a spring that yields, with distance rather than time, as its force approaches breakaway.
//
//     f = s0 z        dz/dt = w - s0 |w| z / L(F)
//
// At constant L the loop of f against position is f = +-L - (+-L - f0) exp(-+s0 x / L), at any speed: rate independent,
// no Stribeck effect, no separate static friction. An oscillation around a bias creeps (the model drifts in presliding).
//
// Source: P. R. Dahl, "A solid friction model", Aerospace Corp. TOR-0158(3107-18)-1, 1968, with exponent 1. The stiffness
// is scaled to this arm: F moves by 3 mN before it slides at 0.5 N, as in the paper's gradual transitions.

#include "plant/truth/arm.h"

#include <math.h>

typedef struct
{
    double stiffness;
} dahl_t;

static double update(const void *law, const sim_law_step_t *step, double end_speed, double z_end[])
{
    const dahl_t *dahl = law;
    const double  s0   = dahl->stiffness;
    const double  x    = step->length_s * end_speed;
    z_end[0]           = (step->z[0] + x) / (1.0 + s0 * fabs(x) / sim_law_breakaway(&step->start, end_speed));
    return s0 * z_end[0];
}

static double friction(const void *law, const sim_contact_t *now, const double z[])
{
    (void)now;
    return ((const dahl_t *)law)->stiffness * z[0];
}

static void rates(const void *law, const sim_contact_t *now, const double z[], double dz[])
{
    const double w = now->speed_deg_per_s;
    dz[0]          = w - ((const dahl_t *)law)->stiffness * fabs(w) * z[0] / sim_law_breakaway(now, w);
}

static const sim_law_t law = {.size        = sizeof(dahl_t),
                              .own_size    = sizeof(dahl_t),
                              .state_count = 1,
                              .turns       = true,
                              .update      = update,
                              .friction    = friction,
                              .rates       = rates};

static const common_key_t keys[] = {
    SIM_TRUTH_NUMBER(dahl_t,
                     stiffness,
                     "stiffness_N_per_deg",
                     "N/deg",
                     1.0,
                     1e6,
                     200.0,
                     "stiffness at small deflection"),
    SIM_TRUTH_END,
};

SIM_ARM_TRUTH(dahl, law, keys);
