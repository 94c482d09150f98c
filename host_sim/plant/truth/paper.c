// The paper's friction, Eqs. (3) to (9), in double precision:
//
//     f = sat(k(v) L tanh(n / (k(v) L)))  when Q,  sat(n) otherwise          v = d|n|/dt, L = L(F)
//
// Gradual after a deep fall, sharp after a shallow one; depends on the rate of n only through k(v).
// `curve` and `limited` make the five steps of its section 3 and the lines of Figs. 6 and 7 (tests/truth/test_paper.c).
//
// One fixed step, as in the compensator's own model: friction from u and F at the start of the step, then the arm by its
// exact zero-order-hold matrices with u and f held. The relays' logic is the library's. The delay line is our own, because
// 3 ms can be any number of plant steps.
//
// In continuous time v switches Q, Q switches f, and f reverses v. Below about 0.017 N/s, where F creeps up on the curve
// faster than u rises, this holds v at 0 (a sliding mode in Filippov's sense: F' = u', f between curve and n). The fixed
// steps chatter around it.
//
// Source: the paper (DOI 10.1115/1.4004580). Sliding mode: A. F. Filippov, Differential Equations with Discontinuous
// Righthand Sides, 1988.

#include "plant/truth/paper.h"
#include "plant/breakaway.h"
#include "plant/truth/arm.h"
#include "support/elementary.h"
#include "tribo/friction_f32.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define RELAYS_AT_REST (TRIBO_RELAY_SET1 | TRIBO_RELAY_SET2)

typedef struct
{
    common_friction_config_t friction;
    sim_paper_parameters_t   p;
    double                   rate_hz;
    sim_arm_matrices_t       arm;
    uint8_t                 *line;
    uint32_t                 width; ///< length of the delay line in steps: the pulse width

    // A step changes the line and all members from here on.
    double              force_n;
    double              speed_n_per_s;
    double              n_n; ///< net force at the last step
    uint32_t            head;
    tribo_relay_latch_t latch;
} paper_truth_t;

static void parts_of(void *model, sim_truth_part_t parts[SIM_TRUTH_PARTS])
{
    paper_truth_t *truth = model;
    parts[0]             = (sim_truth_part_t){&truth->force_n, sizeof *truth - offsetof(paper_truth_t, force_n)};
    parts[1]             = (sim_truth_part_t){truth->line, truth->width};
}

static void destroy(void *model)
{
    paper_truth_t *truth = model;
    if (truth != NULL)
    {
        free(truth->line);
        free(truth);
    }
}

static void *create(const sim_truth_config_t *config, double step_s)
{
    paper_truth_t *truth = calloc(1, sizeof *truth);
    if (truth == NULL)
    {
        return NULL;
    }
    memcpy(&truth->p, config->own, sizeof truth->p);
    truth->friction = config->friction;
    truth->arm      = sim_arm_matrices(&config->arm, step_s);
    truth->rate_hz  = 1.0 / step_s;
    truth->width    = (uint32_t)fmax(1.0, round(config->friction.pulse_width_s / step_s));
    truth->line     = malloc(truth->width);
    if (truth->line == NULL)
    {
        destroy(truth);
        return NULL;
    }
    memset(truth->line, RELAYS_AT_REST, truth->width);
    return truth;
}

static uint8_t relay_events(const paper_truth_t *truth, double n, sim_breakaway_t breakaway)
{
    const common_friction_config_t *friction = &truth->friction;

    const double past   = truth->n_n;
    unsigned     events = 0;
    events |= (n < friction->set_level * breakaway.positive_n) ? TRIBO_RELAY_SET1 : 0u;
    events |= (n > -friction->set_level * breakaway.negative_n) ? TRIBO_RELAY_SET2 : 0u;
    events |= (n > past && past < -friction->reset_level * breakaway.negative_n) ? TRIBO_RELAY_RESET1 : 0u;
    events |= (n < past && past > friction->reset_level * breakaway.positive_n) ? TRIBO_RELAY_RESET2 : 0u;
    return (uint8_t)events;
}

/// The edge detector of Fig. 13 and the relays of Fig. 12.
static uint8_t relays_step(paper_truth_t *truth, uint8_t events)
{
    const uint8_t past       = truth->line[truth->head];
    truth->line[truth->head] = events;
    truth->head              = (truth->head + 1 == truth->width) ? 0 : truth->head + 1;
    return tribo_relay_latch_step(&truth->latch, (uint8_t)(events & ~past));
}

/// Eq. (3), first line, with k from Eq. (5).
static double gradual(const common_friction_config_t *friction, double n, double L, double v)
{
    const double mean = 0.5 * (friction->k_max + friction->k_min);
    const double half = 0.5 * (friction->k_max - friction->k_min);
    const double k    = mean - half * common_tanh(friction->m * (v / friction->v0_n_per_s - 1.0));
    return k * L * common_tanh(n / (k * L));
}

/// Returns true on the gradual curve, from v > 0 and the output of the relay for the sign of n.
static bool on_curve(const sim_paper_parameters_t *p, bool rises, bool armed)
{
    switch (p->curve)
    {
    case SIM_PAPER_CURVE_ALWAYS:
        return true;
    case SIM_PAPER_CURVE_RISING:
        return rises;
    case SIM_PAPER_CURVE_RELAYS:
        return rises && armed;
    case SIM_PAPER_CURVE_NEVER:
    default:
        return false;
    }
}

static double friction_step(paper_truth_t *truth, double n, sim_truth_signals_t *signals)
{
    const sim_breakaway_t breakaway = sim_breakaway_at(&truth->friction.breakaway, truth->force_n);

    const uint8_t relays = relays_step(truth, relay_events(truth, n, breakaway));
    signals->n_n         = n;
    signals->L_n         = (n >= 0.0) ? breakaway.positive_n : breakaway.negative_n;
    signals->v_n_per_s   = (fabs(n) - fabs(truth->n_n)) * truth->rate_hz;
    signals->q1          = (relays & TRIBO_RELAY_Q1) != 0;
    signals->q2          = (relays & TRIBO_RELAY_Q2) != 0;
    const bool armed     = (n > 0.0 && signals->q2) || (n < 0.0 && signals->q1);
    signals->q           = on_curve(&truth->p, signals->v_n_per_s > 0.0, armed);

    double f = signals->q ? gradual(&truth->friction, n, signals->L_n, signals->v_n_per_s) : n;
    if (truth->p.limited != 0)
    {
        f = (f > breakaway.positive_n) ? breakaway.positive_n : (f < -breakaway.negative_n) ? -breakaway.negative_n : f;
    }
    signals->f_n = f;
    truth->n_n   = n;
    return signals->f_n;
}

static double step(void *model, double u_n, sim_truth_signals_t *signals)
{
    paper_truth_t *truth = model;

    const double n     = u_n - truth->force_n + truth->friction.gravity_n;
    const double drive = n - friction_step(truth, n, signals);
    truth->force_n += truth->arm.phi_d * drive + truth->arm.phi_g * truth->speed_n_per_s;
    truth->speed_n_per_s = truth->arm.gamma_d * drive + truth->arm.gamma_g * truth->speed_n_per_s;
    return truth->force_n;
}

// In continuous time: comparators and their edges, by CVODE's root finding. Comparators that toggle faster than the pulse
// of Fig. 13 are not modelled.

typedef struct
{
    double set_s, reset_s; ///< when the inputs last rose
    bool   set, reset;     ///< inputs
    bool   out;
} relay_t;

typedef struct
{
    common_friction_config_t friction;
    common_arm_config_t      arm;
    sim_paper_parameters_t   p;
    bool                     n_rises;
    bool                     below, above; ///< n < c1 L+, n > -c1 L-
    bool                     under, over;  ///< n < -c2 L-, n > c2 L+
    bool                     holds;        ///< the sliding mode v = 0
    relay_t                  relay1, relay2;
} paper_law_t;

#define LONG_AGO_S (-1e9)

/// In the sliding mode, a dn/dt larger than this comes from a kink of u.
#define HELD_N_PER_S 1e-6

static void law_reset(void *law, const sim_truth_config_t *config, double z[])
{
    paper_law_t *paper = law;
    (void)z;
    *paper = (paper_law_t){.friction = config->friction,
                           .arm      = config->arm,
                           .n_rises  = true,
                           .below    = true,
                           .above    = true,
                           .relay1   = {.set_s = LONG_AGO_S, .reset_s = LONG_AGO_S, .set = true},
                           .relay2   = {.set_s = LONG_AGO_S, .reset_s = LONG_AGO_S, .set = true}};
    memcpy(&paper->p, config->own, sizeof paper->p);
}

/// Samples and holds the set pulse at the rising edge of (set pulse or reset pulse).
static void relay_take(relay_t *relay, bool set, bool reset, double time_s, double pulse_s)
{
    const bool set_pulse   = relay->set && time_s - relay->set_s < pulse_s;
    const bool reset_pulse = relay->reset && time_s - relay->reset_s < pulse_s;
    if (set && !relay->set)
    {
        relay->set_s = time_s;
        relay->out   = relay->out || !reset_pulse;
    }
    if (reset && !relay->reset)
    {
        relay->reset_s = time_s;
        relay->out     = relay->out && set_pulse;
    }
    relay->set   = set;
    relay->reset = reset;
}

static double limited(const paper_law_t *paper, const sim_contact_t *now, double f)
{
    return paper->p.limited != 0 ? sim_law_limit(now, f) : f;
}

static double on_the_curve(const paper_law_t *paper, const sim_contact_t *now, double v)
{
    return limited(paper, now, gradual(&paper->friction, now->n_n, sim_law_breakaway(now, now->n_n), v));
}

static bool armed(const paper_law_t *paper, const sim_contact_t *now)
{
    return now->n_n > 0.0 ? paper->relay2.out : paper->relay1.out;
}

/// Returns the friction that keeps v at 0: F' = u'.
static double holding(const paper_law_t *paper, const sim_contact_t *now)
{
    const double acceleration = now->u_rate_n_per_s2 / paper->arm.stiffness;
    return now->n_n - paper->arm.damping * now->speed_deg_per_s - paper->arm.inertia * acceleration;
}

static double law_friction(const void *law, const sim_contact_t *now, const double z[])
{
    const paper_law_t *paper = law;
    (void)z;
    if (paper->holds)
    {
        return holding(paper, now);
    }
    const double v     = copysign(1.0, now->n_n) * now->n_rate_n_per_s;
    const bool   rises = paper->n_rises == (now->n_n > 0.0);
    return on_curve(&paper->p, rises, armed(paper, now)) ? on_the_curve(paper, now, v) : limited(paper, now, now->n_n);
}

enum
{
    N_TURNS,
    BELOW,
    ABOVE,
    UNDER,
    OVER,
    LEAVES_FOR_CURVE,
    LEAVES_FOR_N,
    GUARDS
};

static void law_guards(const void *law, const sim_contact_t *now, const double z[], double g[])
{
    const paper_law_t *paper = law;
    (void)z;
    const double n     = now->n_n;
    const double rate  = now->n_rate_n_per_s;
    const double set   = paper->friction.set_level;
    const double reset = paper->friction.reset_level;

    const double below = set * now->breakaway.positive_n - n;
    const double above = n + set * now->breakaway.negative_n;
    const double under = -reset * now->breakaway.negative_n - n;
    const double over  = n - reset * now->breakaway.positive_n;
    g[N_TURNS]         = paper->holds ? HELD_N_PER_S - fabs(rate) : paper->n_rises ? rate : -rate;
    g[BELOW]           = paper->below ? below : -below;
    g[ABOVE]           = paper->above ? above : -above;
    g[UNDER]           = paper->under ? under : -under;
    g[OVER]            = paper->over ? over : -over;

    const double side   = copysign(1.0, n);
    const double hold   = holding(paper, now);
    g[LEAVES_FOR_CURVE] = paper->holds ? side * (hold - on_the_curve(paper, now, 0.0)) : 1.0;
    g[LEAVES_FOR_N]     = paper->holds ? side * (limited(paper, now, n) - hold) : 1.0;
}

/// Returns true if both branches drive v towards 0: on the curve F overtakes u, off it F falls behind.
static bool is_held(const paper_law_t *paper, const sim_contact_t *now)
{
    if (!on_curve(&paper->p, true, armed(paper, now)) || on_curve(&paper->p, false, armed(paper, now)))
    {
        return false;
    }
    const double side = copysign(1.0, now->n_n);
    const double hold = holding(paper, now);
    return side * (hold - on_the_curve(paper, now, 0.0)) > 0.0 && side * (limited(paper, now, now->n_n) - hold) > 0.0;
}

static void take_relays(paper_law_t *paper, const sim_contact_t *now)
{
    const double pulse_s = paper->friction.pulse_width_s;
    // In the sliding mode n falls as often as it rises.
    const bool rises = paper->n_rises || paper->holds;
    const bool falls = !paper->n_rises || paper->holds;
    relay_take(&paper->relay1, paper->below, rises && paper->under, now->time_s, pulse_s);
    relay_take(&paper->relay2, paper->above, falls && paper->over, now->time_s, pulse_s);
}

static void law_cross(void *law, sim_contact_t *now, double z[], unsigned guard)
{
    paper_law_t *paper = law;
    (void)z;
    switch (guard)
    {
    case N_TURNS:
        // A kink of u is not a reversal; away from the root the sign of dn/dt is reliable.
        paper->n_rises = fabs(now->n_rate_n_per_s) > HELD_N_PER_S ? now->n_rate_n_per_s > 0.0 : !paper->n_rises;
        paper->holds   = fabs(now->n_rate_n_per_s) <= HELD_N_PER_S && is_held(paper, now);
        break;
    case BELOW:
        paper->below = !paper->below;
        break;
    case ABOVE:
        paper->above = !paper->above;
        break;
    case UNDER:
        paper->under = !paper->under;
        break;
    case OVER:
        paper->over = !paper->over;
        break;
    case LEAVES_FOR_CURVE:
        paper->holds   = false;
        paper->n_rises = now->n_n > 0.0;
        break;
    default:
        paper->holds   = false;
        paper->n_rises = now->n_n <= 0.0;
        break;
    }
    take_relays(paper, now);
    if (paper->holds && !is_held(paper, now))
    {
        // A relay went low, so v rises again off the curve.
        paper->holds   = false;
        paper->n_rises = now->n_n > 0.0;
    }
}

static const sim_law_t law = {.size        = sizeof(paper_law_t),
                              .guard_count = GUARDS,
                              .reset       = law_reset,
                              .friction    = law_friction,
                              .guards      = law_guards,
                              .cross       = law_cross};

static const char *const curves[]    = {[SIM_PAPER_CURVE_NEVER]  = "never",
                                        [SIM_PAPER_CURVE_ALWAYS] = "always",
                                        [SIM_PAPER_CURVE_RISING] = "rising",
                                        [SIM_PAPER_CURVE_RELAYS] = "relays",
                                        NULL};
static const char *const no_or_yes[] = {"no", "yes", NULL};

// clang-format off: one row a key
static const common_key_t keys[] = {
    SIM_TRUTH_CHOICE(sim_paper_parameters_t, limited, "limited", no_or_yes, 1, "whether f is limited to L; no: step 1 of section 3"),
    SIM_TRUTH_CHOICE(sim_paper_parameters_t, curve, "curve", curves, SIM_PAPER_CURVE_RELAYS, "when the gradual curve holds: relays means Eq. (8), rising means v > 0"),
    SIM_TRUTH_END,
};
// clang-format on

const sim_truth_ops_t sim_paper_truth =
    {.name = "paper", .create = create, .step = step, .destroy = destroy, .parts = parts_of, .keys = keys, .law = &law};
