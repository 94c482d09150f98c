#include "plant/truth/arm.h"

#include "plant/zoh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/// No law needs so many, because the bracket at least halves every second iteration.
#define ITERATIONS_MAX 100

/// Tolerances of the root, in deg/s and as a fraction of the bracket: 1e-11 deg/s adds up to 4e-8 N of F in 1,000 s.
#define ROOT_DEG_PER_S 1e-11
#define ROOT_PART      1e-10

typedef struct
{
    double z[SIM_LAW_STATES_MAX];
    double time_s;
    double force_n;
    double speed; ///< deg/s
    double n_n;   ///< net force at the start of the last step
} arm_state_t;

typedef struct
{
    const sim_law_t   *law;
    sim_truth_config_t config;
    void              *friction; ///< struct of the law
    sim_arm_matrices_t matrices;
    double             step_s;
    arm_state_t        now;
} arm_t;

/// With d = u + g - f - F the arm obeys d'' = -(K/I) d - (b/I) d' while u and f are held, and F' = -d'.
sim_arm_matrices_t sim_arm_matrices(const common_arm_config_t *arm, double step_s)
{
    const double stiffness = arm->stiffness / arm->inertia;
    const double damping   = arm->damping / arm->inertia;
    const double a[4]      = {0.0, 1.0, -stiffness, -damping};
    double       phi[4];
    sim_zoh_transition(a, step_s, phi);
    return (sim_arm_matrices_t){1.0 - phi[0], phi[1], -phi[2], phi[3]};
}

void sim_arm_parts(void *model, sim_truth_part_t parts[SIM_TRUTH_PARTS])
{
    arm_t *arm = model;
    parts[0]   = (sim_truth_part_t){&arm->now, sizeof arm->now};
    parts[1]   = (sim_truth_part_t){arm->friction, arm->law->size};
}

void sim_arm_destroy(void *model)
{
    arm_t *arm = model;
    if (arm != NULL)
    {
        free(arm->friction);
        free(arm);
    }
}

static unsigned steps_of(const sim_law_t *law)
{
    return law->steps == 0 ? 1 : law->steps;
}

void *sim_arm_create(const sim_law_t *law, const sim_truth_config_t *config, double step_s)
{
    arm_t *arm = calloc(1, sizeof *arm);
    if (arm == NULL)
    {
        return NULL;
    }
    arm->friction = calloc(1, law->size);
    if (arm->friction == NULL)
    {
        free(arm);
        return NULL;
    }
    arm->law      = law;
    arm->config   = *config;
    arm->step_s   = step_s / steps_of(law);
    arm->matrices = sim_arm_matrices(&config->arm, arm->step_s);
    sim_law_reset(law, arm->friction, &arm->config, arm->now.z);
    return arm;
}

/// The equation of one step.
typedef struct
{
    const arm_t   *arm;
    sim_law_step_t given;
    double         free_speed; ///< w0
    double         per_newton; ///< c
    double         end_speed;  ///< w1, once solved
    double         z_end[SIM_LAW_STATES_MAX];
} step_t;

static double friction_at(step_t *step, double end_speed)
{
    return step->arm->law->update(step->arm->friction, &step->given, end_speed, step->z_end);
}

/// Finds the root on one side of rest, where friction is continuous, by regula falsi with the Illinois rule. The bracket
/// reaches from 0, where friction is `friction`, to the speed after a step with this friction. If friction falls with speed,
/// the root may be beyond; the speed after a step with that friction is then the next end of the bracket.
static double solve_moving(step_t *step, double friction)
{
    const double width = step->free_speed - step->per_newton * friction;
    const double near  = ROOT_DEG_PER_S + ROOT_PART * fabs(width);

    double low        = copysign(0.0, width);
    double low_error  = -width;
    double high       = width;
    double f          = friction_at(step, high);
    double high_error = high - (step->free_speed - step->per_newton * f);
    for (int i = 0; i < ITERATIONS_MAX && fabs(high_error) > near; i++)
    {
        const bool   between = (high_error < 0.0) != (low_error < 0.0);
        const double middle  = between ? high - high_error * (high - low) / (high_error - low_error)
                                       : step->free_speed - step->per_newton * f;
        f                    = friction_at(step, middle);
        const double error   = middle - (step->free_speed - step->per_newton * f);
        if (between && (error < 0.0) == (high_error < 0.0))
        {
            low_error *= 0.5;
        }
        else
        {
            low       = high;
            low_error = high_error;
        }
        high       = middle;
        high_error = error;
    }
    step->end_speed = step->free_speed - step->per_newton * f;
    return f;
}

/// Returns true if the arm moves in direction `way` in this step; `f` is the friction then.
static bool moves(step_t *step, double way, double *f)
{
    const double at_rest = friction_at(step, copysign(0.0, way));
    const bool   free    = way * (step->free_speed - step->per_newton * at_rest) > 0.0;
    if (free)
    {
        *f = solve_moving(step, at_rest);
    }
    return free;
}

/// Returns the friction to hold over the step, with its z_end. The present direction is tried first, because both directions
/// can be solutions if friction falls from rest to sliding.
static double solve(step_t *step)
{
    const double way = copysign(1.0, step->given.start.speed_deg_per_s);
    double       f;
    if (moves(step, way, &f) || moves(step, -way, &f))
    {
        return f;
    }
    step->end_speed = 0.0;
    return step->free_speed / step->per_newton;
}

static sim_contact_t contact_of(const arm_t *arm, double u_n)
{
    return (sim_contact_t){.time_s          = arm->now.time_s,
                           .u_n             = u_n,
                           .n_n             = u_n + arm->config.friction.gravity_n - arm->now.force_n,
                           .force_n         = arm->now.force_n,
                           .speed_deg_per_s = arm->now.speed,
                           .breakaway       = sim_breakaway_at(&arm->config.friction.breakaway, arm->now.force_n)};
}

static void step_once(arm_t *arm, double u_n, sim_truth_signals_t *signals)
{
    const double stiffness = arm->config.arm.stiffness;
    const double rate      = stiffness * arm->now.speed;
    step_t       step      = {.arm        = arm,
                              .given      = {.start = contact_of(arm, u_n), .z = arm->now.z, .length_s = arm->step_s},
                              .per_newton = arm->matrices.gamma_d / stiffness};
    const double n         = step.given.start.n_n;
    step.free_speed        = (arm->matrices.gamma_d * n + arm->matrices.gamma_g * rate) / stiffness;

    const double f     = solve(&step);
    signals->n_n       = n;
    signals->L_n       = sim_law_breakaway(&step.given.start, n);
    signals->v_n_per_s = (fabs(n) - fabs(arm->now.n_n)) / arm->step_s;
    signals->f_n       = f;
    arm->now.n_n       = n;

    const bool rests = (arm->now.speed == 0.0 && step.end_speed == 0.0) ||
                       (arm->law->stands != NULL && arm->law->stands(arm->friction));
    arm->now.speed = step.end_speed;
    if (!rests)
    {
        arm->now.force_n += arm->matrices.phi_d * (n - f) + arm->matrices.phi_g * rate;
    }
    memcpy(arm->now.z, step.z_end, sizeof arm->now.z);
    arm->now.time_s += arm->step_s;
    if (arm->law->settle != NULL)
    {
        sim_contact_t end = contact_of(arm, u_n);
        end.breakaway     = step.given.start.breakaway;
        arm->law->settle(arm->friction, &end, arm->now.z);
    }
}

double sim_arm_step(void *model, double u_n, sim_truth_signals_t *signals)
{
    arm_t              *arm = model;
    sim_truth_signals_t later;
    step_once(arm, u_n, signals);
    for (unsigned i = 1; i < steps_of(arm->law); i++)
    {
        step_once(arm, u_n, &later);
    }
    return arm->now.force_n;
}
