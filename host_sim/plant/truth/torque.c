// Torque-based friction: the contact balances the net force up to breakaway, at any speed.
//
//     f = sat(n, L(F))                                                            Eq. (11) of the paper
//
// Inside breakaway I w' = -b w: the arm glides to a stop within I/b (4 ms), then stands. No states, no hysteresis.
//
// Source: the paper's references 22 to 24 (the torque-based model of constrained arms), in the form of its Eq. (11), with a
// load-dependent L.

#include "plant/truth/arm.h"

typedef struct
{
    char nothing; ///< the law has no memory
} torque_t;

static double friction(const void *law, const sim_contact_t *now, const double z[])
{
    (void)law;
    (void)z;
    return sim_law_limit(now, now->n_n);
}

static double update(const void *law, const sim_law_step_t *step, double end_speed, double z_end[])
{
    (void)end_speed;
    (void)z_end;
    return friction(law, &step->start, step->z);
}

static const sim_law_t law = {.size = sizeof(torque_t), .update = update, .friction = friction};

SIM_ARM_TRUTH(torque, law, NULL);
