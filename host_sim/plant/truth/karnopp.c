// Karnopp's friction: a speed below `dead_zone` counts as rest.
//
//     f = sat(n, L(F)) and theta' = 0    while |w| < dv     (momentum still accumulates: I w' = n - f)
//     f = r L(F) sgn(w), theta' = w      otherwise
//
// L is the breakaway level, r L the sliding level. Where |n| <= L the position stands exactly.
// Here n contains -K theta; b w is part of the arm.
//
// Source: D. Karnopp, "Computer simulation of stick-slip friction in mechanical dynamic systems", ASME J. Dynamic
// Systems, Measurement, and Control 107, 1985. The dead zone is scaled to the arm: r at 0.01 N/s moves it by 0.0026 deg/s.

#include "plant/truth/arm.h"

#include <math.h>

typedef struct
{
    double dead_zone;
    double sliding_ratio;
} parameters_t;

typedef struct
{
    parameters_t p;
    int          way; ///< direction of sliding, 0 inside the dead zone
} karnopp_t;

static bool stands(const void *law)
{
    const karnopp_t *karnopp = law;
    return karnopp->way == 0;
}

static double update(const void *law, const sim_law_step_t *step, double end_speed, double z_end[])
{
    const karnopp_t *karnopp = law;
    (void)z_end;
    if (karnopp->way == 0)
    {
        return sim_law_limit(&step->start, step->start.n_n);
    }
    return copysign(karnopp->p.sliding_ratio * sim_law_breakaway(&step->start, end_speed), end_speed);
}

static void settle(void *law, const sim_contact_t *end, double z[])
{
    karnopp_t   *karnopp = law;
    const double speed   = end->speed_deg_per_s;
    (void)z;
    karnopp->way = fabs(speed) < karnopp->p.dead_zone ? 0 : speed > 0.0 ? 1 : -1;
}

static double friction(const void *law, const sim_contact_t *now, const double z[])
{
    const karnopp_t *karnopp = law;
    (void)z;
    if (karnopp->way == 0)
    {
        return sim_law_limit(now, now->n_n);
    }
    return karnopp->way * karnopp->p.sliding_ratio * sim_law_breakaway(now, karnopp->way);
}

enum
{
    STOPS_OR_SLIDES_UP,
    SLIDES_DOWN,
    GUARDS
};

static void guards(const void *law, const sim_contact_t *now, const double z[], double g[])
{
    const karnopp_t *karnopp = law;
    (void)z;
    const double speed = now->speed_deg_per_s;
    const double zone  = karnopp->p.dead_zone;

    g[STOPS_OR_SLIDES_UP] = karnopp->way != 0 ? karnopp->way * speed - zone : zone - speed;
    g[SLIDES_DOWN]        = karnopp->way != 0 ? 1.0 : zone + speed;
}

static void cross(void *law, sim_contact_t *now, double z[], unsigned guard)
{
    karnopp_t *karnopp = law;
    (void)now;
    (void)z;
    karnopp->way = karnopp->way != 0 ? 0 : guard == SLIDES_DOWN ? -1 : 1;
}

static const sim_law_t law = {.size        = sizeof(karnopp_t),
                              .own_size    = sizeof(parameters_t),
                              .guard_count = GUARDS,
                              .update      = update,
                              .settle      = settle,
                              .stands      = stands,
                              .friction    = friction,
                              .guards      = guards,
                              .cross       = cross};

// clang-format off: one row a key
static const common_key_t keys[] = {
    SIM_TRUTH_NUMBER(parameters_t, dead_zone, "dead_zone_deg_per_s", "deg/s", 1e-6, 1.0, 2e-4, "speeds below it count as rest"),
    SIM_TRUTH_NUMBER(parameters_t, sliding_ratio, "sliding_ratio", "-", 0.1, 1.0, 1.0, "friction of sliding divided by breakaway"),
    SIM_TRUTH_END,
};
// clang-format on

SIM_ARM_TRUTH(karnopp, law, keys);
