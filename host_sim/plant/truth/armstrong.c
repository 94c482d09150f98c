// Armstrong's model with seven parameters: one law while stuck, another while sliding.
//
//     stuck:    f = kt x,  x from the position without force, up to breakaway
//               Fs = Fc + (L - Fc) s,   s(t) = s0 + (1 - s0) t / (t + g)        t: time stuck, s0: s at the stop
//     sliding:  f = (Fc + (L - Fc) s / (1 + (m / ws)^2)) sgn(w) + Fv w          s: its value at breakaway
//               dm/dt = (|w| - m) / tl                                          m: |w| with frictional memory
//
// Breakaway rises to L with the time stuck. Sliding friction falls with speed (Stribeck) to Fc = r L, with a lag.
// Presliding is elastic: no drift. The seven are kt, r (Fc), Fv, L (Fs), ws, tl, g.
//
// Source: B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, "A survey of models, analysis tools and compensation methods
// for the control of machines with friction", Automatica 30(7), 1994. There |w| is delayed by tl. Here it has a first-order
// lag of tl, a differential equation, and f does not jump at a stop. Scaled as in dahl.c.

#include "plant/truth/arm.h"
#include "support/elementary.h"

#include <math.h>

typedef struct
{
    double stiffness;
    double sliding_ratio;
    double viscous;
    double stribeck_speed;
    double memory;
    double dwell;
} parameters_t;

enum
{
    STRETCH, ///< x
    MEMORY   ///< m
};

typedef struct
{
    parameters_t p;
    int          way;   ///< direction of sliding, 0 while stuck
    double       share; ///< s0 while stuck, s while sliding
    double       stuck_s;
} armstrong_t;

static void reset(void *law, const sim_truth_config_t *config, double z[])
{
    (void)config;
    (void)z;
    ((armstrong_t *)law)->share = 1.0; // the arm has rested forever
}

static double share_now(const armstrong_t *armstrong, double time_s)
{
    const double stuck = time_s - armstrong->stuck_s;
    return armstrong->share + (1.0 - armstrong->share) * stuck / (stuck + armstrong->p.dwell);
}

static double level(const armstrong_t *armstrong, const sim_contact_t *contact, double way, double share)
{
    const double sliding = armstrong->p.sliding_ratio;
    return (sliding + (1.0 - sliding) * share) * sim_law_breakaway(contact, way);
}

/// Returns the share, reduced by the remembered speed (Stribeck).
static double remembered(const armstrong_t *armstrong, double memory)
{
    const double part = memory / armstrong->p.stribeck_speed;
    return armstrong->share / (1.0 + part * part);
}

static double sliding(const armstrong_t *armstrong, const sim_contact_t *contact, double memory, double w)
{
    const int way = armstrong->way;
    return way * level(armstrong, contact, way, remembered(armstrong, memory)) + armstrong->p.viscous * w;
}

static double stuck(const armstrong_t *armstrong, const sim_contact_t *contact, double stretch)
{
    const double share = share_now(armstrong, contact->time_s);
    return fmin(level(armstrong, contact, 1.0, share),
                fmax(-level(armstrong, contact, -1.0, share), armstrong->p.stiffness * stretch));
}

/// STRETCH is 0 while sliding. After a stop within the step it is the deflection of the spring that takes over.
static double update(const void *law, const sim_law_step_t *step, double end_speed, double z_end[])
{
    const armstrong_t *armstrong = law;
    const double       x         = step->length_s * end_speed;
    if (armstrong->way == 0)
    {
        z_end[STRETCH] = step->z[STRETCH] + x;
        z_end[MEMORY]  = 0.0;
        return stuck(armstrong, &step->start, z_end[STRETCH]);
    }
    const double f = sliding(armstrong, &step->start, step->z[MEMORY], 0.0);
    if ((signbit(end_speed) != 0) == (armstrong->way < 0))
    {
        z_end[STRETCH] = 0.0;
        z_end[MEMORY] =
            step->z[MEMORY] - (fabs(end_speed) - step->z[MEMORY]) * common_expm1(-step->length_s / armstrong->p.memory);
        return f + armstrong->p.viscous * end_speed;
    }
    z_end[STRETCH] = f / armstrong->p.stiffness + x;
    z_end[MEMORY]  = step->z[MEMORY];
    return armstrong->p.stiffness * z_end[STRETCH];
}

static void break_away(armstrong_t *armstrong, int way, double time_s, double z[])
{
    armstrong->share = share_now(armstrong, time_s);
    armstrong->way   = way;
    z[STRETCH]       = 0.0;
    z[MEMORY]        = 0.0;
}

static void stop(armstrong_t *armstrong, double stretch, double time_s, double z[])
{
    armstrong->share   = remembered(armstrong, z[MEMORY]);
    armstrong->stuck_s = time_s;
    armstrong->way     = 0;
    z[STRETCH]         = stretch;
    z[MEMORY]          = 0.0;
}

static void settle(void *law, const sim_contact_t *end, double z[])
{
    armstrong_t *armstrong = law;
    const double w         = end->speed_deg_per_s;
    if (armstrong->way == 0)
    {
        const double share  = share_now(armstrong, end->time_s);
        const double spring = armstrong->p.stiffness * z[STRETCH];
        if (spring > level(armstrong, end, 1.0, share) || spring < -level(armstrong, end, -1.0, share))
        {
            break_away(armstrong, spring > 0.0 ? 1 : -1, end->time_s, z);
        }
    }
    else if (z[STRETCH] != 0.0 || armstrong->way * w <= 0.0)
    {
        const double there = sliding(armstrong, end, z[MEMORY], 0.0) / armstrong->p.stiffness;
        stop(armstrong, z[STRETCH] != 0.0 ? z[STRETCH] : there, end->time_s, z);
    }
}

static void rates(const void *law, const sim_contact_t *now, const double z[], double dz[])
{
    const armstrong_t *armstrong = law;
    dz[STRETCH]                  = armstrong->way == 0 ? now->speed_deg_per_s : 0.0;
    dz[MEMORY] = armstrong->way == 0 ? 0.0 : (fabs(now->speed_deg_per_s) - z[MEMORY]) / armstrong->p.memory;
}

static double friction(const void *law, const sim_contact_t *now, const double z[])
{
    const armstrong_t *armstrong = law;
    return armstrong->way == 0 ? armstrong->p.stiffness * z[STRETCH]
                               : sliding(armstrong, now, z[MEMORY], now->speed_deg_per_s);
}

enum
{
    STOPS_OR_SLIDES_UP,
    SLIDES_DOWN,
    GUARDS
};

static void guards(const void *law, const sim_contact_t *now, const double z[], double g[])
{
    const armstrong_t *armstrong = law;
    const double       share     = share_now(armstrong, now->time_s);
    const double       spring    = armstrong->p.stiffness * z[STRETCH];
    const bool         moves     = armstrong->way != 0;

    g[STOPS_OR_SLIDES_UP] = moves ? armstrong->way * now->speed_deg_per_s : level(armstrong, now, 1.0, share) - spring;
    g[SLIDES_DOWN]        = moves ? 1.0 : level(armstrong, now, -1.0, share) + spring;
}

static void cross(void *law, sim_contact_t *now, double z[], unsigned guard)
{
    armstrong_t *armstrong = law;
    if (armstrong->way == 0)
    {
        break_away(armstrong, guard == SLIDES_DOWN ? -1 : 1, now->time_s, z);
        return;
    }
    stop(armstrong, sliding(armstrong, now, z[MEMORY], 0.0) / armstrong->p.stiffness, now->time_s, z);
}

static const sim_law_t law = {.size        = sizeof(armstrong_t),
                              .own_size    = sizeof(parameters_t),
                              .state_count = 2,
                              .guard_count = GUARDS,
                              .reset       = reset,
                              .update      = update,
                              .settle      = settle,
                              .friction    = friction,
                              .rates       = rates,
                              .guards      = guards,
                              .cross       = cross};

// clang-format off: one row a key
static const common_key_t keys[] = {
    SIM_TRUTH_NUMBER(parameters_t, stiffness, "stiffness_N_per_deg", "N/deg", 1.0, 1e6, 200.0, "kt, while stuck"),
    SIM_TRUTH_NUMBER(parameters_t, sliding_ratio, "sliding_ratio", "-", 0.1, 1.0, 0.95, "r: friction of fast sliding divided by breakaway after a long rest"),
    SIM_TRUTH_NUMBER(parameters_t, viscous, "viscous_N_s_per_deg", "N s/deg", 0.0, 10.0, 0.0, "Fv, added to the arm's own"),
    SIM_TRUTH_NUMBER(parameters_t, stribeck_speed, "stribeck_speed_deg_per_s", "deg/s", 1e-5, 100.0, 0.01, "ws: speed at which half of the excess is left"),
    SIM_TRUTH_NUMBER(parameters_t, memory, "memory_s", "s", 1e-4, 1.0, 0.005, "tl: lag of friction behind speed"),
    SIM_TRUTH_NUMBER(parameters_t, dwell, "dwell_s", "s", 1e-3, 1e3, 1.0, "g: time at rest after which half of the lost breakaway is back"),
    SIM_TRUTH_END,
};
// clang-format on

SIM_ARM_TRUTH(armstrong, law, keys);
