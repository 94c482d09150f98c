// Coulomb friction, set-valued at rest.
//
//     f = s(w) L(F) sgn(w)    while w is not 0,    s(w) = r + (1 - r) exp(-(w / ws)^2)
//     f = n, |n| <= L(F)      at rest
//
// The arm stands exactly, or slides against all of L: no presliding motion, no memory. Below r = 1 friction falls with
// speed (Stribeck).
//
// Source: C. A. Coulomb, Theorie des machines simples, 1785; here with a load-dependent L. R. Stribeck, Die wesentlichen
// Eigenschaften der Gleit- und Rollenlager, VDI-Zeitschrift 46, 1902; as a curve B. Armstrong-Helouvry, P. Dupont,
// C. Canudas de Wit, Automatica 30(7), 1994.

#include "plant/truth/arm.h"
#include "plant/truth/stribeck.h"

#include <math.h>

typedef struct
{
    double sliding_ratio;
    double stribeck_speed;
} parameters_t;

typedef struct
{
    parameters_t p;
    int          way; ///< direction of sliding, 0 at rest
} coulomb_t;

/// Returns the friction of sliding towards `side` at speed w.
static double sliding(const coulomb_t *coulomb, const sim_contact_t *contact, double side, double w)
{
    return sim_stribeck(coulomb->p.sliding_ratio, w, coulomb->p.stribeck_speed) * sim_law_breakaway(contact, side);
}

static double update(const void *law, const sim_law_step_t *step, double end_speed, double z_end[])
{
    (void)z_end;
    return copysign(sliding(law, &step->start, end_speed, step->start.speed_deg_per_s), end_speed);
}

static double friction(const void *law, const sim_contact_t *now, const double z[])
{
    const coulomb_t *coulomb = law;
    (void)z;
    return coulomb->way == 0 ? now->n_n : coulomb->way * sliding(coulomb, now, coulomb->way, now->speed_deg_per_s);
}

enum
{
    STOPS_OR_SLIDES_UP,
    SLIDES_DOWN,
    GUARDS
};

static void guards(const void *law, const sim_contact_t *now, const double z[], double g[])
{
    const coulomb_t *coulomb = law;
    (void)z;
    const bool moves      = coulomb->way != 0;
    g[STOPS_OR_SLIDES_UP] = moves ? coulomb->way * now->speed_deg_per_s : now->breakaway.positive_n - now->n_n;
    g[SLIDES_DOWN]        = moves ? 1.0 : now->breakaway.negative_n + now->n_n;
}

static void cross(void *law, sim_contact_t *now, double z[], unsigned guard)
{
    coulomb_t *coulomb = law;
    (void)z;
    if (coulomb->way == 0)
    {
        coulomb->way = guard == SLIDES_DOWN ? -1 : 1;
        return;
    }
    now->speed_deg_per_s = 0.0;
    coulomb->way         = now->n_n > now->breakaway.positive_n ? 1 : now->n_n < -now->breakaway.negative_n ? -1 : 0;
}

static const sim_law_t law = {.size        = sizeof(coulomb_t),
                              .own_size    = sizeof(parameters_t),
                              .guard_count = GUARDS,
                              .update      = update,
                              .friction    = friction,
                              .guards      = guards,
                              .cross       = cross};

static const common_key_t keys[] = {
    SIM_STRIBECK_KEYS(parameters_t),
    SIM_TRUTH_END,
};

SIM_ARM_TRUTH(coulomb, law, keys);
