// The paper's arm and friction, Eqs. (2) to (9), in double precision. One step, as in the compensator's own model:
// friction from u and F at the start of the step, then the arm by its exact zero-order-hold matrices with u and f
// held. The relays' logic is the library's; the delay line is our own, as 3 ms can be any number of plant steps.

#include "plant/breakaway.h"
#include "plant/truth.h"
#include "plant/zoh.h"
#include "tribo/relay.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define RELAYS_AT_REST (TRIBO_RELAY_SET1 | TRIBO_RELAY_SET2)

typedef struct
{
    sim_friction_config_t friction;
    double                rate_hz;
    double                phi_d, phi_g, gamma_d, gamma_g; ///< arm_f32.h, with G the speed in N/s

    double              force_n;
    double              speed_n_per_s;
    double              n_n; ///< net force at the last step
    uint8_t            *line;
    uint32_t            width; ///< of the line, in steps: the pulse width
    uint32_t            head;
    tribo_relay_latch_t latch;
} paper_truth_t;

static void reset(void *model)
{
    paper_truth_t *truth = model;
    truth->force_n       = 0.0;
    truth->speed_n_per_s = 0.0;
    truth->n_n           = 0.0;
    truth->head          = 0;
    truth->latch         = (tribo_relay_latch_t){0};
    memset(truth->line, RELAYS_AT_REST, truth->width);
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

/// With d = u + g - f - F the arm obeys d'' = -(K/I) d - (b/I) d' while u and f are held, and F' = -d'.
static void discretise(paper_truth_t *truth, const sim_arm_config_t *arm, double step_s)
{
    const double stiffness = arm->stiffness_n_per_deg / arm->inertia_n_s2_per_deg;
    const double damping   = arm->damping_n_s_per_deg / arm->inertia_n_s2_per_deg;
    const double a[4]      = {0.0, 1.0, -stiffness, -damping};
    double       phi[4];
    sim_zoh_transition(a, step_s, phi);
    truth->phi_d   = 1.0 - phi[0];
    truth->phi_g   = phi[1];
    truth->gamma_d = -phi[2];
    truth->gamma_g = phi[3];
}

static void *create(const sim_truth_config_t *config, double step_s)
{
    paper_truth_t *truth = calloc(1, sizeof *truth);
    if (truth == NULL)
    {
        return NULL;
    }
    truth->friction = config->friction;
    truth->rate_hz  = 1.0 / step_s;
    truth->width    = (uint32_t)fmax(1.0, round(config->friction.pulse_width_s / step_s));
    truth->line     = malloc(truth->width);
    if (truth->line == NULL)
    {
        destroy(truth);
        return NULL;
    }
    discretise(truth, &config->arm, step_s);
    reset(truth);
    return truth;
}

static uint8_t relay_events(const paper_truth_t *truth, double n, sim_breakaway_t breakaway)
{
    const sim_friction_config_t *friction = &truth->friction;

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
static double gradual(const sim_friction_config_t *friction, double n, double L, double v)
{
    const double mean = 0.5 * (friction->k_max + friction->k_min);
    const double half = 0.5 * (friction->k_max - friction->k_min);
    const double k    = mean - half * tanh(friction->m * (v / friction->v0_n_per_s - 1.0));
    return k * L * tanh(n / (k * L));
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
    signals->q           = signals->v_n_per_s > 0.0 && ((n > 0.0 && signals->q2) || (n < 0.0 && signals->q1));

    const double f = signals->q ? gradual(&truth->friction, n, signals->L_n, signals->v_n_per_s) : n;
    signals->f_n   = (f > breakaway.positive_n)    ? breakaway.positive_n
                     : (f < -breakaway.negative_n) ? -breakaway.negative_n
                                                   : f;
    truth->n_n     = n;
    return signals->f_n;
}

static double step(void *model, double u_n, sim_truth_signals_t *signals)
{
    paper_truth_t *truth = model;

    const double n     = u_n - truth->force_n + truth->friction.gravity_n;
    const double drive = n - friction_step(truth, n, signals);
    truth->force_n += truth->phi_d * drive + truth->phi_g * truth->speed_n_per_s;
    truth->speed_n_per_s = truth->gamma_d * drive + truth->gamma_g * truth->speed_n_per_s;
    return truth->force_n;
}

const sim_truth_ops_t sim_paper_truth = {.name    = "paper",
                                         .create  = create,
                                         .reset   = reset,
                                         .step    = step,
                                         .destroy = destroy};
