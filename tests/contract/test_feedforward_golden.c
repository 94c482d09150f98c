// The golden vectors of the feed-forward's double-precision model (tests/golden/feedforward.py), tick by tick,
// through the interface of a method: r, y, v and u are given, so no loop is needed and an error does not feed back.

#include ARITH_HEADER
#include "csv.h"
#include "runs.h"
#include "unity.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define COLUMNS                                                                                                        \
    "event,entry,share,r,y,v,u,limited,e,mode,lin,f,lead,b,term,sigma,z,V0,V1,V2,c0,c2,doubt,P00,P43,turned,xi,left"
#define ROWS_MAX RUNS(INT_MAX, 1500) // an emulated processor computes the host's bits (tests/identity, tests/lock_step)

enum
{
    EVENT,
    ENTRY,
    SHARE,
    R,
    Y,
    V,
    U,
    LIMITED,
    E,
    MODE,
    LIN,
    F,
    LEAD,
    B,
    TERM,
    SIGMA,
    Z,
    V0,
    V1,
    V2,
    C0,
    C2,
    DOUBT,
    P00,
    P43,
    TURNED,
    XI,
    LEFT,
    COLUMN_COUNT
};

/// What happens before a tick.
enum
{
    NOTHING,
    RESTART,
    ENTER,
    CHANGE,
    RESET
};

static const char *const names[COLUMN_COUNT] = {
    "event", "entry", "share", "r",  "y",  "v",  "u",  "limited", "e",     "mode", "lin", "f",      "lead", "b",
    "term",  "sigma", "z",     "V0", "V1", "V2", "c0", "c2",      "doubt", "P00",  "P43", "turned", "xi",   "left"};

static TRIBO(force_loop, params_t) params;
static TRIBO(feedforward, params_t) feedforward;
static TRIBO(feedforward, memory_t) memory;
static TRIBO(force_loop, state_t) loop;
static tribo_point_t table[TRIBO_BREAKAWAY_POINTS_MAX];
static double        full_scale_n;

static double force(double x)
{
    return TRIBO_EITHER(x, x * full_scale_n / 2147483648.0);
}

/// Converts a force from Q29.
static double inner(double x)
{
    return TRIBO_EITHER(x, x * full_scale_n / 536870912.0);
}

static double number(double x, int q)
{
    (void)q;
    return TRIBO_EITHER(x, ldexp(x, -q));
}

static void happen(const double *c)
{
    TRIBO(force_loop, functions_t) functions;
    feedforward.method.functions(&functions);
    switch ((int)c[EVENT])
    {
    case RESTART:
        functions.start(&memory, true);
        break;
    case ENTER:
        functions.enter(&memory, tribo_force_of_n(c[ENTRY], full_scale_n), true);
        break;
    case CHANGE:
        functions.enter(&memory, memory.state.tick.TRIBO_N(term), false);
        break;
    case RESET:
        TRIBO(feedforward, reset)(&memory.state);
        break;
    default:
        break;
    }
}

static void tick(const double *c, double *found)
{
    TRIBO(force_loop, signals_t) signals = {.controller = {.limited = c[LIMITED] != 0.0}};
    happen(c);
    TRIBO(force_loop, functions_t) functions;
    feedforward.method.functions(&functions);
    const tribo_force_t e =
        functions.error(&params,
                        &memory,
                        tribo_force_of_n(c[R], full_scale_n),
                        tribo_force_of_n(c[Y], full_scale_n),
                        c[SHARE] == 1.0 ? TRIBO_ALL : TRIBO_EITHER((float)c[SHARE], (uint32_t)ldexp(c[SHARE], 32)));
    const tribo_force_t v     = tribo_force_of_n(c[V], full_scale_n);
    const tribo_force_t added = functions.term(&params, &memory, v);
    functions.after(&params, &memory, v, tribo_force_of_n(c[U], full_scale_n), &signals);
    (void)TRIBO(feedforward, learn)(&params, &memory);
    const TRIBO(feedforward, state_t) *x       = &memory.state;
    const tribo_feedforward_learner_t *learner = &x->learner;
    const float                       *S       = feedforward.learning.deviation;

    found[E]      = force((double)e);
    found[MODE]   = x->mode;
    found[LIN]    = inner((double)x->lin);
    found[F]      = inner((double)x->f);
    found[LEAD]   = inner((double)x->lead);
    found[B]      = inner((double)x->b);
    found[TERM]   = force((double)added);
    found[SIGMA]  = number((double)x->sigma, 29);
    found[Z]      = inner((double)x->friction);
    found[V0]     = 1.0 + (double)(S[0] * learner->a[0]);
    found[V1]     = (double)(S[1] * learner->a[1]);
    found[V2]     = (double)(S[2] * learner->a[2]);
    found[C0]     = (double)(S[3] * learner->a[3]);
    found[C2]     = (double)(S[4] * learner->a[4]);
    found[DOUBT]  = (double)learner->doubt;
    found[P00]    = (double)learner->P[0];
    found[P43]    = (double)learner->P[13];
    found[TURNED] = number((double)x->weights.turned, 29);
    found[XI]     = (double)learner->ratio;
    found[LEFT]   = learner->left;
}

/// In N, `most_n`: 2^-24 of 2 N is 1e-7, and a jump's lead has 3.5 times a difference of f, which has the error of the weights. Of a weight,
/// 2e-5: the gain of a sample divides by the error's square.
static double tolerance(int column, double most_n)
{
    switch (column)
    {
    case MODE:
    case LEFT:
        return 0.0;
    case SIGMA:
    case DOUBT:
    case V0:
    case V1:
    case V2:
    case C2:
    case P00:
    case P43:
    case TURNED:
    case XI:
        return 2e-5;
    default:
        return most_n;
    }
}

/// With the params that were made last.
static void play(const char *name, double most_n)
{
    csv_t  csv;
    double worst[COLUMN_COUNT] = {0.0};
    int    first               = 0; // row that is off
    memset(&memory, 0, sizeof memory);
    loop.memory = &memory.state.tick;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, TRIBO(force_loop, start)(&loop, &params, false));
    csv_open(&csv, name, COLUMNS);
    while (csv.rows < ROWS_MAX && csv_next(&csv))
    {
        double found[COLUMN_COUNT];
        tick(csv.value, found);
        for (int i = E; i < COLUMN_COUNT; i++)
        {
            const double off = fabs(found[i] - csv.value[i]);
            first            = first == 0 && off > tolerance(i, most_n) ? csv.rows : first;
            worst[i]         = isnan(csv.value[i]) || off <= worst[i] ? worst[i] : off; // a NaN that is found stays
        }
    }
    printf("%s, first off in row %d, within:", name, first);
    for (int i = E; i < COLUMN_COUNT; i++)
    {
        printf(" %s %.1e", names[i], worst[i]);
    }
    printf("\n");
    for (int i = E; i < COLUMN_COUNT; i++)
    {
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(tolerance(i, most_n), 0.0, worst[i], names[i]);
    }
}

static void check(const char                           *name,
                  const tribo_force_loop_f32_config_t  *config,
                  const tribo_feedforward_f32_config_t *own,
                  double                                scale_n,
                  double                                most_n)
{
    full_scale_n = scale_n;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_init_feedforward(&params, table, &feedforward, config, own, (float)scale_n));
    play(name, most_n);
}

/// The paper's rig, with a controller that is not run, for any sample time.
static tribo_force_loop_f32_config_t beside_at(double sample_time_s)
{
    static const tribo_biquad_f32_section_t beside[] = {TRIBO_BIQUAD_F32(1.0, -0.9, 0.0, -0.95, 0.0)};
    tribo_force_loop_f32_config_t           config   = tribo_force_loop_f32_paper();
    config.sample_time_s                             = (float)sample_time_s;
    config.controller.sections                       = beside;
    config.controller.section_count                  = 1;
    return config;
}

static void check_paper(const char *name, double sample_time_s)
{
    tribo_force_loop_f32_config_t        config = beside_at(sample_time_s);
    const tribo_feedforward_f32_config_t own    = tribo_feedforward_f32_default();
    check(name, &config, &own, 4.0, 3e-6);
}

static void test_feedforward_tracks_as_its_model(void)
{
    check_paper("feedforward_tracking.csv", 1e-3);
}

static void test_feedforward_takes_noise_as_its_model(void)
{
    check_paper("feedforward_noise.csv", 4e-3);
}

static void test_feedforward_holds_as_its_model(void)
{
    check_paper("feedforward_hold.csv", 4e-3);
    check_paper("feedforward_chatter.csv", 4e-3);
}

static void test_feedforward_feeds_back_as_its_model(void)
{
    check_paper("feedforward_monitor.csv", 4e-3);
}

static void test_feedforward_takes_limits_and_bad_inputs_as_its_model(void)
{
    check_paper("feedforward_limits.csv", 4e-3);
}

static void test_feedforward_is_handed_over_as_its_model(void)
{
    check_paper("feedforward_changes.csv", 4e-3);
}

static void test_feedforward_of_another_rig_does_as_its_model(void)
{
    static const tribo_breakaway_point_f32_t points[] = {{0.0f, 3.0f, 2.0f},
                                                         {40.0f, 8.0f, 9.0f},
                                                         {80.0f, 14.0f, 18.0f}};
    tribo_force_loop_f32_config_t            config   = beside_at(5e-4);
    const tribo_feedforward_f32_config_t     own      = {.actuator_pole_rad_per_s = 700.0f,
                                                         .sensor_pole_rad_per_s   = 300.0f,
                                                         .reversal_n              = 0.06f,
                                                         .presliding_n            = 2.0f,
                                                         .jump_time_s             = 0.009f,
                                                         .jump_lead               = 0.5f,
                                                         .trust                   = 0.7f,
                                                         .forgetting_per_n        = 0.002f,
                                                         .still_time_s            = 0.05f};
    config.input_max_n                                = 200.0f;
    config.usual_force_n                              = 50.0f;
    config.compensator.friction.table                 = points;
    config.compensator.friction.table_length          = 3u;
    config.compensator.friction.gravity_n             = 1.5f;
    config.compensator.arm.stiffness                  = 2e6f;
    config.compensator.arm.damping                    = 2800.0f;
    config.compensator.arm.inertia                    = 2.0f;
    check("feedforward_rig.csv", &config, &own, 512.0, 2e-4);
}

#include "runners/test_feedforward_golden.inc" // main
