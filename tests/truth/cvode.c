#include "cvode.h"

#include <cvode/cvode.h>
#include <math.h>
#include <nvector/nvector_serial.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>
#include <time.h>

enum
{
    POSITION,
    SPEED,
    LAW ///< its own states from here on
};

/// Largest number of events without progress in time.
#define STALLED_EVENTS_MAX 1000
#define STALLED_S          1e-13

#define INTERNAL_STEPS_MAX 1000000L

/// Debian 12 has SUNDIALS 6, Debian 13 has 7.
#if SUNDIALS_VERSION_MAJOR >= 7
#define NO_COMMUNICATOR SUN_COMM_NULL
#else
#define NO_COMMUNICATOR NULL
#endif

struct cvode
{
    const sim_law_t   *law;
    sim_truth_config_t config;
    sim_drive_error_t  drive_error;
    void              *friction;
    int                way; ///< sign of the speed, where the law turns
    cvode_drive_at_t   at;
    const void        *context;
    double             time_s;
    double             until_s;
    SUNContext         sundials;
    void              *cvode;
    N_Vector           y, tolerance;
    SUNMatrix          jacobian;
    SUNLinearSolver    solver;
    SUNNonlinearSolver iteration; ///< without a Jacobian; null: Newton's
    cvode_cost_t       cost;      ///< of earlier starts, no longer counted by CVODE
    char               problem[96];
};

const cvode_options_t cvode_defaults = {.relative_tolerance = 1e-8,
                                        .position_deg       = 1e-11,
                                        .speed_deg_per_s    = 1e-10,
                                        .states             = 1e-13};

/// u with the errors of the drive at that position and speed.
static cvode_drive_t drive_at(const cvode_t *reference, double time_s, double position, double speed)
{
    const sim_drive_error_t *error     = &reference->drive_error;
    const cvode_drive_t      command   = reference->at(reference->context, time_s);
    const sim_ripple_t       ripple    = sim_drive_error_ripple(error, position);
    const double             scale     = 1.0 + error->scale;
    const double             stiffness = reference->config.arm.stiffness;
    // The second derivative contains w'. It is used only where w' = u'' / K (the sliding mode of paper.c).
    const double second = scale * command.rate_n_per_s2 + ripple.curvature_n_per_deg2 * speed * speed;
    return (cvode_drive_t){.u_n           = sim_drive_error_command(error, command.u_n) + ripple.force_n,
                           .rate_n_per_s  = scale * command.rate_n_per_s + ripple.slope_n_per_deg * speed,
                           .rate_n_per_s2 = second * stiffness / (stiffness - ripple.slope_n_per_deg)};
}

static sim_contact_t contact_at(const cvode_t *reference, double time_s, const double y[])
{
    const cvode_drive_t drive = drive_at(reference, time_s, y[POSITION], y[SPEED]);
    const double        force = reference->config.arm.stiffness * y[POSITION];
    return (sim_contact_t){.time_s          = time_s,
                           .u_n             = drive.u_n,
                           .n_n             = drive.u_n + reference->config.friction.gravity_n - force,
                           .force_n         = force,
                           .speed_deg_per_s = y[SPEED],
                           .breakaway       = sim_breakaway_at(&reference->config.friction.breakaway, force),
                           .u_rate_n_per_s  = drive.rate_n_per_s,
                           .u_rate_n_per_s2 = drive.rate_n_per_s2,
                           .n_rate_n_per_s  = drive.rate_n_per_s - reference->config.arm.stiffness * y[SPEED]};
}

static int right_hand_side(sunrealtype time_s, N_Vector y_vector, N_Vector rate_vector, void *user)
{
    const cvode_t             *reference = user;
    const common_arm_config_t *arm       = &reference->config.arm;
    const double              *y         = N_VGetArrayPointer(y_vector);
    double                    *rate      = N_VGetArrayPointer(rate_vector);

    const sim_contact_t now    = contact_at(reference, time_s, y);
    const double        f      = reference->law->friction(reference->friction, &now, y + LAW);
    const bool          stands = reference->law->stands != NULL && reference->law->stands(reference->friction);
    rate[POSITION]             = stands ? 0.0 : y[SPEED];
    rate[SPEED]                = (now.n_n - arm->damping * rate[POSITION] - f) / arm->inertia;
    if (reference->law->rates != NULL)
    {
        reference->law->rates(reference->friction, &now, y + LAW, rate + LAW);
    }
    return 0;
}

static unsigned guard_count(const sim_law_t *law)
{
    return law->turns ? 1 : law->guard_count;
}

/// The law's guards or, for a law without modes, the one that restarts the integrator at a kink of |w|.
static void guards_at(const cvode_t *reference, const sim_contact_t *now, const double y[], double g[])
{
    if (reference->law->turns)
    {
        g[0] = reference->way * now->speed_deg_per_s + SIM_LAW_TURN_DEG_PER_S;
    }
    else if (reference->law->guards != NULL)
    {
        reference->law->guards(reference->friction, now, y + LAW, g);
    }
}

static void cross(cvode_t *reference, sim_contact_t *now, double y[], unsigned guard)
{
    if (reference->law->turns)
    {
        reference->way = -reference->way;
    }
    else
    {
        reference->law->cross(reference->friction, now, y + LAW, guard);
        y[SPEED] = now->speed_deg_per_s;
    }
}

static int guards(sunrealtype time_s, N_Vector y_vector, sunrealtype *g, void *user)
{
    const cvode_t      *reference = user;
    const double       *y         = N_VGetArrayPointer(y_vector);
    const sim_contact_t now       = contact_at(reference, time_s, y);
    guards_at(reference, &now, y, g);
    return 0;
}

static cvode_drive_t no_drive(const void *context, double time_s)
{
    (void)context;
    (void)time_s;
    return (cvode_drive_t){0};
}

static bool allocate(cvode_t *reference, const cvode_options_t *options)
{
    const sunindextype size = LAW + (sunindextype)reference->law->state_count;
    reference->friction     = calloc(1, reference->law->size);
    if (reference->friction == NULL || SUNContext_Create(NO_COMMUNICATOR, &reference->sundials) != 0)
    {
        return false;
    }
    reference->y         = N_VNew_Serial(size, reference->sundials);
    reference->tolerance = N_VNew_Serial(size, reference->sundials);
    reference->jacobian  = SUNDenseMatrix(size, size, reference->sundials);
    reference->cvode     = CVodeCreate(options->adams ? CV_ADAMS : CV_BDF, reference->sundials);
    if (reference->y == NULL || reference->tolerance == NULL || reference->jacobian == NULL || reference->cvode == NULL)
    {
        return false;
    }
    if (options->adams)
    {
        reference->iteration = SUNNonlinSol_FixedPoint(reference->y, 0, reference->sundials);
        return reference->iteration != NULL;
    }
    reference->solver = SUNLinSol_Dense(reference->y, reference->jacobian, reference->sundials);
    return reference->solver != NULL;
}

/// Silences CVODE's messages; its status suffices.
static bool be_silent(cvode_t *reference)
{
#if SUNDIALS_VERSION_MAJOR >= 7
    return SUNContext_ClearErrHandlers(reference->sundials) == 0;
#else
    return CVodeSetErrFile(reference->cvode, NULL) == CV_SUCCESS;
#endif
}

static bool set_up(cvode_t *reference, const cvode_options_t *options)
{
    double *tolerance = N_VGetArrayPointer(reference->tolerance);
    for (unsigned i = 0; i < reference->law->state_count; i++)
    {
        tolerance[LAW + i] = options->states;
    }
    tolerance[POSITION] = options->position_deg;
    tolerance[SPEED]    = options->speed_deg_per_s;
    N_VConst(0.0, reference->y);
    sim_law_reset(reference->law, reference->friction, &reference->config, N_VGetArrayPointer(reference->y) + LAW);

    void     *cvode = reference->cvode;
    const int count = (int)guard_count(reference->law);
    bool      done  = CVodeInit(cvode, right_hand_side, 0.0, reference->y) == CV_SUCCESS;
    done            = done && CVodeSVtolerances(cvode, options->relative_tolerance, reference->tolerance) == CV_SUCCESS;
    done            = done && CVodeSetUserData(cvode, reference) == CV_SUCCESS;
    done            = done && (options->adams ? CVodeSetNonlinearSolver(cvode, reference->iteration)
                                              : CVodeSetLinearSolver(cvode, reference->solver, reference->jacobian)) == CV_SUCCESS;
    done            = done && CVodeSetMaxNumSteps(cvode, INTERNAL_STEPS_MAX) == CV_SUCCESS;
    done            = done && CVodeSetMaxStep(cvode, options->max_step_s) == CV_SUCCESS;
    done            = done && be_silent(reference);
    if (done && count > 0)
    {
        int falling[SIM_LAW_GUARDS_MAX];
        for (int i = 0; i < count; i++)
        {
            falling[i] = -1;
        }
        done = CVodeRootInit(cvode, count, guards) == CV_SUCCESS;
        done = done && CVodeSetRootDirection(cvode, falling) == CV_SUCCESS;
        done = done && CVodeSetNoInactiveRootWarn(cvode) == CV_SUCCESS;
    }
    return done;
}

cvode_t *cvode_create(const sim_truth_ops_t *truth, const sim_truth_config_t *config, const cvode_options_t *options)
{
    cvode_t *reference = calloc(1, sizeof *reference);
    if (reference == NULL)
    {
        return NULL;
    }
    reference->law    = truth->law;
    reference->config = *config;
    reference->way    = 1;
    reference->at     = no_drive;
    if (!allocate(reference, options) || !set_up(reference, options))
    {
        cvode_destroy(reference);
        return NULL;
    }
    return reference;
}

void cvode_set_drive_error(cvode_t *reference, const sim_drive_error_t *error)
{
    reference->drive_error = *error;
}

void cvode_destroy(cvode_t *reference)
{
    if (reference == NULL)
    {
        return;
    }
    CVodeFree(&reference->cvode);
    (void)SUNNonlinSolFree(reference->iteration);
    (void)SUNLinSolFree(reference->solver);
    SUNMatDestroy(reference->jacobian);
    N_VDestroy(reference->tolerance);
    N_VDestroy(reference->y);
    (void)SUNContext_Free(&reference->sundials);
    free(reference->friction);
    free(reference);
}

/// CVODE's counts since its last start.
static cvode_cost_t counted(const cvode_t *reference)
{
    long steps    = 0;
    long calls    = 0;
    long jacobian = 0;
    (void)CVodeGetNumSteps(reference->cvode, &steps);
    (void)CVodeGetNumRhsEvals(reference->cvode, &calls);
    (void)CVodeGetNumLinRhsEvals(reference->cvode, &jacobian);
    return (cvode_cost_t){.steps = steps, .right_hand_sides = calls + jacobian};
}

static bool failed(cvode_t *reference, const char *what, int flag)
{
    (void)snprintf(reference->problem, sizeof reference->problem, "%s (%d) at %.9g s", what, flag, reference->time_s);
    return false;
}

/// Restarts CVODE, which also resets its counters.
static bool restart(cvode_t *reference)
{
    const cvode_cost_t past = counted(reference);
    reference->cost.steps += past.steps;
    reference->cost.right_hand_sides += past.right_hand_sides;

    int flag = CVodeReInit(reference->cvode, reference->time_s, reference->y);
    if (flag == CV_SUCCESS)
    {
        flag = CVodeSetStopTime(reference->cvode, reference->until_s);
    }
    return flag == CV_SUCCESS || failed(reference, "CVODE does not start", flag);
}

/// A kink of the input may leave guards negative, which CVODE would miss: their events happen now.
static void cross_at_break(cvode_t *reference)
{
    double  g[SIM_LAW_GUARDS_MAX] = {0.0};
    double *y                     = N_VGetArrayPointer(reference->y);
    for (unsigned i = 0; i < guard_count(reference->law); i++)
    {
        sim_contact_t now = contact_at(reference, reference->time_s, y);
        guards_at(reference, &now, y, g);
        if (g[i] < 0.0)
        {
            cross(reference, &now, y, i);
        }
    }
}

bool cvode_drive(cvode_t *reference, cvode_drive_at_t at, const void *context, double until_s)
{
    reference->at      = at;
    reference->context = context;
    reference->until_s = until_s;
    cross_at_break(reference);
    return restart(reference);
}

static bool switch_modes(cvode_t *reference)
{
    int found[SIM_LAW_GUARDS_MAX] = {0};
    (void)CVodeGetRootInfo(reference->cvode, found);

    double       *y   = N_VGetArrayPointer(reference->y);
    sim_contact_t now = contact_at(reference, reference->time_s, y);
    for (unsigned i = 0; i < guard_count(reference->law); i++)
    {
        if (found[i] != 0)
        {
            cross(reference, &now, y, i);
            reference->cost.events++;
        }
    }
    return restart(reference);
}

static bool integrate(cvode_t *reference, double time_s)
{
    int    stalled = 0;
    double last_s  = -1.0;
    while (reference->time_s < time_s)
    {
        const int flag = CVode(reference->cvode, time_s, reference->y, &reference->time_s, CV_NORMAL);
        if (flag < 0)
        {
            return failed(reference, "CVODE gave up", flag);
        }
        if (flag == CV_ROOT_RETURN)
        {
            stalled = reference->time_s - last_s > STALLED_S ? 0 : stalled + 1;
            last_s  = reference->time_s;
            if (stalled > STALLED_EVENTS_MAX)
            {
                return failed(reference, "modes change without end", flag);
            }
            if (!switch_modes(reference))
            {
                return false;
            }
        }
    }
    return true;
}

bool cvode_advance(cvode_t *reference, double time_s)
{
    const clock_t start = clock();
    const bool    done  = integrate(reference, time_s);
    reference->cost.seconds += (double)(clock() - start) / CLOCKS_PER_SEC;
    return done;
}

const char *cvode_problem(const cvode_t *reference)
{
    return reference->problem;
}

double cvode_force(const cvode_t *reference)
{
    return reference->config.arm.stiffness * N_VGetArrayPointer(reference->y)[POSITION];
}

double cvode_speed(const cvode_t *reference)
{
    return N_VGetArrayPointer(reference->y)[SPEED];
}

double cvode_friction(const cvode_t *reference)
{
    const double       *y   = N_VGetArrayPointer(reference->y);
    const sim_contact_t now = contact_at(reference, reference->time_s, y);
    return reference->law->friction(reference->friction, &now, y + LAW);
}

cvode_cost_t cvode_cost(const cvode_t *reference)
{
    const cvode_cost_t past = counted(reference);
    cvode_cost_t       cost = reference->cost;
    cost.steps += past.steps;
    cost.right_hand_sides += past.right_hand_sides;
    return cost;
}
