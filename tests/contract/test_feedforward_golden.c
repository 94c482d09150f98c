// The golden vectors of the feed-forward's two double-precision models (tests/golden/feedforward.py, feedforward_again.py), tick by tick,
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
    "event,entry,share,r,y,v,u,limited,e,mode,lin,f,lead,b,term,sigma,z,V0,V1,V2,V3,V4,c0,c1,c2,doubt,"                \
    "P4,lambda,turns,xi,back,forgotten"
#define ROWS_MAX RUNS(INT_MAX, 3000) // an emulated processor computes the host's bits (tests/identity, tests/lock_step)

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
    V3,
    V4,
    C0,
    C1,
    C2,
    DOUBT,
    P4,
    LAMBDA,
    TURNS,
    XI,
    BACK,
    FORGOTTEN,
    COLUMN_COUNT
};

/// What happens before a tick.
enum
{
    NOTHING,
    RESTART,
    ENTER,
    CHANGE,
    RESET,
    RESTORE,
    CORRUPT,
    TO_OTHER,
    CORRUPT_OFFSET
};

static const char *const names[COLUMN_COUNT] = {
    "event", "entry", "share", "r",     "y",     "v",      "u",     "limited", "e",    "mode",     "lin",
    "f",     "lead",  "b",     "term",  "sigma", "z",      "V0",    "V1",      "V2",   "V3",       "V4",
    "c0",    "c1",    "c2",    "doubt", "P4",    "lambda", "turns", "xi",      "back", "forgotten"};

static TRIBO(force_loop, params_t) params[2]; // those in use, and others to change to
static TRIBO(feedforward, params_t) feedforward[2];
static unsigned used;
static TRIBO(feedforward, memory_t) memory;
static TRIBO(force_loop, state_t) loop;
static tribo_point_t table[2][TRIBO_BREAKAWAY_POINTS_MAX];
static double        full_scale_n;

void setUp(void)
{
}

void tearDown(void)
{
}

static double force(double x)
{
    return TRIBO_EITHER(x, x * full_scale_n / 2147483648.0);
}

/// Of a force in Q29.
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
    feedforward[used].method.functions(&functions);
    switch ((int)c[EVENT])
    {
    case RESTART:
        TRIBO(force_loop_feedforward, attach)(&loop, &memory);
        break;
    case ENTER:
        functions.enter(&memory, tribo_force_of_n(c[ENTRY], full_scale_n), true);
        break;
    case CHANGE:
    case TO_OTHER:
        used = c[EVENT] == (double)TO_OTHER ? 1u - used : used;
        functions.enter(&memory, memory.state.tick.TRIBO_N(term), false);
        break;
    case RESET:
        TRIBO(feedforward, reset)(&memory.state);
        break;
    case RESTORE:
        TRIBO(feedforward, restore)(&memory.state);
        break;
    case CORRUPT:
        memory.state.learned.weight[0] = TRIBO_EITHER((float)c[ENTRY], (int32_t)ldexp(c[ENTRY], 29));
        break;
    case CORRUPT_OFFSET:
        memory.state.TRIBO_N(offset) = TRIBO_EITHER((float)c[ENTRY], (int32_t)ldexp(c[ENTRY] / full_scale_n, 29));
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
    feedforward[used].method.functions(&functions);
    const tribo_force_t e =
        functions.error(&params[used],
                        &memory,
                        tribo_force_of_n(c[R], full_scale_n),
                        tribo_force_of_n(c[Y], full_scale_n),
                        c[SHARE] == 1.0 ? TRIBO_ALL : TRIBO_EITHER((float)c[SHARE], (uint32_t)ldexp(c[SHARE], 32)));
    const tribo_force_t v     = tribo_force_of_n(c[V], full_scale_n);
    const tribo_force_t added = functions.term(&params[used], &memory, v);
    functions.after(&params[used], &memory, v, tribo_force_of_n(c[U], full_scale_n), &signals);
    const TRIBO(feedforward, signals_t) *seen = &memory.signals;
    const TRIBO(feedforward, state_t) *state  = &memory.state;
    found[E]                                  = force((double)e);
    found[MODE]                               = state->mode;
    found[LIN]                                = inner((double)seen->TRIBO_N(lin));
    found[F]                                  = inner((double)seen->TRIBO_N(f));
    found[LEAD]                               = inner((double)seen->TRIBO_N(lead));
    found[B]                                  = inner((double)seen->TRIBO_N(b));
    found[TERM]                               = force((double)added);
    found[SIGMA]                              = number((double)state->sigma, 29);
    found[Z]                                  = inner((double)seen->TRIBO_N(friction));
    for (int j = 0; j < 5; j++)
    {
        found[V0 + j] = number((double)state->learned.weight[j], 29);
    }
    found[C0]        = inner((double)state->learned.TRIBO_N(constant));
    found[C1]        = number((double)state->learned.slope, 29);
    found[C2]        = number((double)state->learned.scale, 29);
    found[DOUBT]     = number((double)state->learned.doubt, 32);
    found[P4]        = number((double)state->learned.variance[3], 30);
    found[LAMBDA]    = number((double)state->hold.extra_margin, 32);
    found[TURNS]     = state->at_bound;
    found[XI]        = number((double)state->monitor.ratio, 29);
    found[BACK]      = state->monitor.feedback.left;
    found[FORGOTTEN] = state->forgotten;
}

/// In N, `most_n`: 2^-24 of 2 N is 1e-7, and a jump's lead has 3.5 times a difference of f, which has the error of the weights.
/// Of a weight, 1e-4: the gain of a sample divides by the error's square.
static double tolerance(int column, double most_n)
{
    switch (column)
    {
    case MODE:
    case TURNS:
    case BACK:
    case FORGOTTEN:
        return 0.0;
    case SIGMA:
    case DOUBT:
    case P4:
    case LAMBDA:
        return 2e-5;
    case V0:
    case V0 + 1:
    case V0 + 2:
    case V0 + 3:
    case V0 + 4:
    case C1:
    case C2:
    case XI:
        return 1e-4;
    default:
        return most_n;
    }
}

static void make(unsigned                              which,
                 const tribo_force_loop_f32_config_t  *config,
                 const tribo_feedforward_f32_config_t *own,
                 double                                scale_n)
{
    used         = which;
    full_scale_n = scale_n;
    TEST_ASSERT_EQUAL_INT(
        TRIBO_OK,
        tribo_init_feedforward(&params[which], table[which], &feedforward[which], config, own, (float)scale_n));
}

/// With the params that were made last.
static void play(const char *name, double most_n)
{
    csv_t  csv;
    double worst[COLUMN_COUNT] = {0.0};
    memset(&memory, 0, sizeof memory);
    TRIBO(feedforward, reset)(&memory.state);
    TRIBO(force_loop, reset)(&loop);
    TRIBO(force_loop_feedforward, attach)(&loop, &memory);
    csv_open(&csv, name, COLUMNS);
    while (csv.rows < ROWS_MAX && csv_next(&csv))
    {
        double found[COLUMN_COUNT];
        tick(csv.value, found);
        for (int i = E; i < COLUMN_COUNT; i++)
        {
            const double off = fabs(found[i] - csv.value[i]);
            worst[i]         = isnan(csv.value[i]) || off <= worst[i] ? worst[i] : off; // a NaN that is found stays
        }
    }
    printf("%s, within:", name);
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
    make(0, config, own, scale_n);
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
    check(name, &config, &own, 4.0, 3e-5);
}

static void test_feedforward_tracks_as_its_model(void)
{
    check_paper("feedforward_tracking.csv", 1e-3);
}

static void test_feedforward_takes_noise_as_its_model(void)
{
    check_paper("feedforward_noise.csv", 1e-3);
}

static void test_feedforward_holds_as_its_model(void)
{
    check_paper("feedforward_hold.csv", 1e-3);
    check_paper("feedforward_chatter.csv", 4e-3);
}

static void test_feedforward_keeps_bounds_as_its_model(void)
{
    check_paper("feedforward_bounds.csv", 4e-3);
}

static void test_feedforward_feeds_back_as_its_model(void)
{
    check_paper("feedforward_monitor.csv", 4e-3);
}

static void test_feedforward_takes_limits_and_bad_inputs_as_its_model(void)
{
    check_paper("feedforward_limits.csv", 1e-3);
}

static void test_feedforward_is_handed_over_as_its_model(void)
{
    check_paper("feedforward_changes.csv", 1e-3);
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
                                                         .still_time_s            = 0.15f};
    config.input_max_n                                = 200.0f;
    config.usual_force_n                              = 50.0f;
    config.controller.u_min_n                         = -200.0f;
    config.controller.u_max_n                         = 200.0f;
    config.compensator.friction.table                 = points;
    config.compensator.friction.table_length          = 3u;
    config.compensator.friction.gravity_n             = 1.5f;
    config.compensator.arm.stiffness                  = 2e6f;
    config.compensator.arm.damping                    = 2800.0f;
    config.compensator.arm.inertia                    = 2.0f;
    check("feedforward_rig.csv", &config, &own, 512.0, 5e-4);
}

static tribo_force_loop_f32_config_t paper_at(double sample_time_s, double input_max_n, float offset_n, float slope)
{
    tribo_force_loop_f32_config_t config          = beside_at(sample_time_s);
    config.input_max_n                            = (float)input_max_n;
    config.usual_force_n                          = 0.25f * (float)input_max_n;
    config.compensator.friction.positive.offset_n = offset_n;
    config.compensator.friction.positive.slope    = slope;
    config.compensator.friction.negative.offset_n = offset_n;
    config.compensator.friction.negative.slope    = slope;
    return config;
}

static void test_feedforward_at_far_rates_does_as_its_second_model(void)
{
    tribo_force_loop_f32_config_t config      = paper_at(0.01, 2.0, 0.007f, 0.3f);
    config.compensator.friction.pulse_width_s = 0.01f; // not read
    tribo_feedforward_f32_config_t own        = tribo_feedforward_f32_default();
    own.jump_time_s                           = 0.004f;
    own.jump_lead                             = 1.0f;
    own.trust                                 = 0.2f;
    own.still_time_s                          = 0.0f;
    check("feedforward_again_coarse.csv", &config, &own, 4.0, 3e-5);
    check_paper("feedforward_again_fine.csv", 2e-4);
}

static void test_feedforward_holds_as_its_second_model(void)
{
    check_paper("feedforward_again_hold.csv", 4e-3);
}

static void differ_by_direction(tribo_friction_f32_config_t *friction)
{
    friction->positive.offset_n = 0.01f;
    friction->positive.slope    = 0.25f;
    friction->negative.offset_n = 0.005f;
    friction->negative.slope    = 0.35f;
}

static void test_feedforward_feeds_back_as_its_second_model(void)
{
    const tribo_force_loop_f32_config_t  config = paper_at(4e-3, 2.0, 0.007f, 0.3f);
    const tribo_feedforward_f32_config_t own    = tribo_feedforward_f32_default();
    tribo_force_loop_f32_config_t        other  = config;
    tribo_feedforward_f32_config_t       others = own;

    differ_by_direction(&other.compensator.friction);
    others.reversal_n   = 1e-3f;
    others.presliding_n = 0.02f;
    others.trust        = 0.7f;
    make(1, &other, &others, 4.0);
    check("feedforward_again_back.csv", &config, &own, 4.0, 3e-5);
}

static void test_feedforward_believes_as_its_second_model(void)
{
    const tribo_force_loop_f32_config_t config = paper_at(4e-3, 0.5, 0.06f, 0.5f);
    const tribo_force_loop_f32_config_t low    = paper_at(4e-3, 0.5, 0.001f, 0.02f);
    tribo_feedforward_f32_config_t      own    = tribo_feedforward_f32_default();
    own.presliding_n                           = 0.01f;
    make(1, &low, &own, 4.0);
    own.presliding_n     = 0.0f;
    own.forgetting_per_n = 2.0f;
    check("feedforward_again_belief.csv", &config, &own, 4.0, 3e-5);
}

static void test_feedforward_changes_params_as_its_second_model(void)
{
    tribo_force_loop_f32_config_t        config = tribo_force_loop_f32_paper();
    const tribo_feedforward_f32_config_t own    = tribo_feedforward_f32_default();
    tribo_force_loop_f32_config_t        other  = config;
    const tribo_feedforward_f32_config_t others = {.actuator_pole_rad_per_s = 150.0f,
                                                   .sensor_pole_rad_per_s   = 80.0f,
                                                   .reversal_n              = 1e-3f,
                                                   .presliding_n            = 0.03f,
                                                   .jump_time_s             = 0.03f,
                                                   .jump_lead               = 0.3f,
                                                   .trust                   = 0.8f,
                                                   .forgetting_per_n        = 0.5f,
                                                   .still_time_s            = 0.1f};
    differ_by_direction(&other.compensator.friction);
    other.compensator.friction.gravity_n = 0.004f;
    make(1, &other, &others, 4.0);
    check("feedforward_again_retune.csv", &config, &own, 4.0, 3e-5);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_feedforward_tracks_as_its_model);
    RUN_TEST(test_feedforward_takes_noise_as_its_model);
    RUN_TEST(test_feedforward_holds_as_its_model);
    RUN_TEST(test_feedforward_keeps_bounds_as_its_model);
    RUN_TEST(test_feedforward_feeds_back_as_its_model);
    RUN_TEST(test_feedforward_takes_limits_and_bad_inputs_as_its_model);
    RUN_TEST(test_feedforward_is_handed_over_as_its_model);
    RUN_TEST(test_feedforward_of_another_rig_does_as_its_model);
    RUN_TEST(test_feedforward_at_far_rates_does_as_its_second_model);
    RUN_TEST(test_feedforward_holds_as_its_second_model);
    RUN_TEST(test_feedforward_feeds_back_as_its_second_model);
    RUN_TEST(test_feedforward_believes_as_its_second_model);
    RUN_TEST(test_feedforward_changes_params_as_its_second_model);
    return UNITY_END();
}
