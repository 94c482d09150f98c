// An axis is the loop, the guard and the method below it, and nothing else: same bits. What it adds: a config that names its next missing
// field, a controller of the caller's, a change of config, a report, and a blob of what is learned. On a plant of its own.

#include ARITH_HEADER
#include "runs.h"
#include "same.h"

#include "tribo/axis_q31.h"
#include "unity.h"

#include <string.h>

typedef TRIBO(axis, t) axis_t;
typedef TRIBO(axis, params_t) axis_params_t;
typedef TRIBO(axis, blob_t) axis_blob_t;

#define H      1e-3
#define PERIOD 8000 // ticks of the triangle

#define ASSERT_BELOW(most, x)  TEST_ASSERT_DOUBLE_WITHIN(most, 0.0, x)
#define ASSERT_ABOVE(least, x) TEST_ASSERT_TRUE_MESSAGE((x) > (least), #x " is not above " #least)

static axis_t axis;

void setUp(void)
{
    memset(&axis, 0, sizeof axis);
}

static tribo_status_t init(axis_t *x, const tribo_axis_f32_config_t *config)
{
    return TRIBO_EITHER(TRIBO(axis, init)(x, config), TRIBO(axis, init)(x, config, (float)FULL_SCALE_N));
}

static tribo_status_t prepare(axis_params_t *next, const tribo_axis_f32_config_t *config)
{
    return TRIBO_EITHER(TRIBO(axis, prepare)(next, config), TRIBO(axis, prepare)(next, config, (float)FULL_SCALE_N));
}

/// A rig whose breakaway is believed at `belief` times the plant's.
static tribo_axis_f32_config_t rig(float belief)
{
    tribo_axis_f32_config_t config             = tribo_axis_f32_config();
    config.sample_time_s                       = (float)H;
    config.u_min_n                             = -1.0f;
    config.u_max_n                             = 1.0f;
    config.positive                            = (tribo_breakaway_f32_t){0.03f * belief, 0.3f * belief};
    config.arm_lag_s                           = 0.0075f;
    config.controller                          = tribo_pi(0.5f, 27.0f);
    config.feedforward.actuator_pole_rad_per_s = 200.0f;
    config.feedforward.sensor_pole_rad_per_s   = 55.0f;
    return config;
}

typedef struct
{
    double actuator, force, reading;
    double u; // of the last tick
} plant_t;

/// Learns as the background of a drive does.
static void learn(axis_t *x)
{
#if TRIBO_IS_Q31
    (void)tribo_axis_q31_learn(x);
#else
    (void)x; // has learned in its tick
#endif
}

/// A pole at 200 rad/s, an arm with a lag of 7.5 ms between its breakaways, a sensor with a pole at 55 rad/s.
static void plant_step(plant_t *x, double u)
{
    const double breakaway = 0.03 + 0.3 * fabs(x->force);
    x->actuator += 0.1813 * (u - x->actuator);
    const double held = fmin(x->actuator + breakaway, fmax(x->actuator - breakaway, x->force));
    x->force += 0.125 * (held - x->force);
    x->reading += 0.0535 * (x->force - x->reading);
}

static double triangle(long tick)
{
    const double phase = (double)(tick % PERIOD) / PERIOD;
    return 0.1 + 0.5 * (phase < 0.5 ? phase : 1.0 - phase);
}

/// Runs from tick `from` to `to`, and returns the RMS error; the largest change of u in a tick is *jump, that of the
/// first tick included unless it is tick 0.
static double run(axis_t *x, plant_t *plant, long from, long to, double *jump)
{
    double sum = 0.0;
    *jump      = 0.0;
    for (long tick = from; tick < to; tick++)
    {
        const double r = triangle(tick);
        const double u = from_force(TRIBO(axis, step)(x, to_force(r), to_force(plant->reading)));
        learn(x);
        *jump    = tick > 0 ? fmax(*jump, fabs(u - plant->u)) : *jump;
        plant->u = u;
        plant_step(plant, u);
        sum += (r - plant->force) * (r - plant->force);
    }
    return sqrt(sum / (double)(to - from));
}

/// Runs `axis` to the tick 4 * PERIOD + 500, and returns the largest change of u in the last 200 ticks, which are straight.
static double run_to_a_straight(plant_t *plant)
{
    double jump;
    (void)run(&axis, plant, 0, 4 * PERIOD + 300, &jump);
    (void)run(&axis, plant, 4 * PERIOD + 300, 4 * PERIOD + 500, &jump);
    return jump;
}

static void test_an_empty_config_is_refused_field_by_field(void)
{
    const tribo_axis_f32_config_t whole  = rig(1.0f);
    tribo_axis_f32_config_t       config = tribo_axis_f32_config();

    TEST_ASSERT_EQUAL(TRIBO_ERR_SAMPLE_TIME, init(&axis, &config));
    config.sample_time_s = whole.sample_time_s;
    TEST_ASSERT_EQUAL(TRIBO_ERR_U_MAX, init(&axis, &config));
    config.u_min_n = whole.u_min_n;
    config.u_max_n = whole.u_max_n;
    TEST_ASSERT_EQUAL(TRIBO_ERR_CONTROLLER, init(&axis, &config));
    TEST_ASSERT_EQUAL_STRING(
        "controller: one of tribo_pi, tribo_sections, tribo_paper and tribo_own; of a loop one of pi and sections",
        tribo_status_text(TRIBO_ERR_CONTROLLER));
    config.controller = whole.controller;
    TEST_ASSERT_EQUAL(TRIBO_ERR_BREAKAWAY_OFFSET, init(&axis, &config));
    config.positive = whole.positive;
    TEST_ASSERT_EQUAL(TRIBO_ERR_ACTUATOR_POLE, init(&axis, &config));
    config.feedforward.actuator_pole_rad_per_s = 200.0f;
    TEST_ASSERT_EQUAL(TRIBO_ERR_SENSOR_POLE, init(&axis, &config));
    config.feedforward.sensor_pole_rad_per_s = 55.0f;
    const axis_t untouched                   = {0};
    TEST_ASSERT_EQUAL_MEMORY(&untouched, &axis, sizeof axis);
    TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
}

static tribo_status_t refused(const tribo_axis_f32_config_t *config)
{
    axis_params_t        params = {0};
    const tribo_status_t status = prepare(&params, config);
    TEST_ASSERT_TRUE((params.loop.method == NULL) == (status != TRIBO_OK));
    return status;
}

static void test_each_field_is_checked(void)
{
    static const float bad[] = {NAN, INFINITY, -INFINITY, -1e9f, 1e9f};
    static const struct
    {
        size_t         at;
        tribo_status_t status;
    } fields[] = {{offsetof(tribo_axis_f32_config_t, sample_time_s), TRIBO_ERR_SAMPLE_TIME},
                  {offsetof(tribo_axis_f32_config_t, u_min_n), TRIBO_ERR_U_MIN},
                  {offsetof(tribo_axis_f32_config_t, u_max_n), TRIBO_ERR_U_MAX},
                  {offsetof(tribo_axis_f32_config_t, input_max_n), TRIBO_ERR_INPUT_MAX},
                  {offsetof(tribo_axis_f32_config_t, arm_lag_s), TRIBO_ERR_AXIS_LAG},
                  {offsetof(tribo_axis_f32_config_t, noise_n), TRIBO_ERR_AXIS_NOISE},
                  {offsetof(tribo_axis_f32_config_t, usual_force_n), TRIBO_ERR_USUAL_FORCE},
                  {offsetof(tribo_axis_f32_config_t, gravity_n), TRIBO_ERR_GRAVITY},
                  {offsetof(tribo_axis_f32_config_t, negative.slope), TRIBO_ERR_BREAKAWAY_NEGATIVE_SLOPE},
                  {offsetof(tribo_axis_f32_config_t, controller.kp), TRIBO_ERR_PI},
                  {offsetof(tribo_axis_f32_config_t, controller.ki_per_s), TRIBO_ERR_PI}};
    for (uint32_t i = 0; i < sizeof bad / sizeof bad[0] * sizeof fields / sizeof fields[0]; i++)
    {
        tribo_axis_f32_config_t config = rig(1.0f);
        config.negative.offset_n       = config.positive.offset_n;
        memcpy((char *)&config + fields[i / 5u].at, &bad[i % 5u], sizeof bad[0]);
        TEST_ASSERT_EQUAL(fields[i / 5u].status, refused(&config));
    }
    tribo_axis_f32_config_t config = rig(1.0f);
    config.controller              = tribo_pi(0.5f, 1001.0f); // its zero would be outside of the unit circle
    TEST_ASSERT_EQUAL(TRIBO_ERR_PI, refused(&config));
    config.controller = tribo_pi(0.0f, 0.0f);
    TEST_ASSERT_EQUAL(TRIBO_ERR_PI, refused(&config));
    config.controller = tribo_pi(0.5f, 0.0f);
    TEST_ASSERT_EQUAL(TRIBO_OK, refused(&config));
    config.negative.slope = 0.3f;
    TEST_ASSERT_EQUAL(TRIBO_ERR_BREAKAWAY_NEGATIVE_OFFSET, refused(&config));
    config.negative.slope = 0.0f;
    config.controller     = tribo_sections(NULL, 2);
    TEST_ASSERT_EQUAL(TRIBO_ERR_NULL, refused(&config));
    config.controller = tribo_paper();
    TEST_ASSERT_EQUAL(TRIBO_OK, refused(&config));
    config.sample_time_s = 0.002f;
    TEST_ASSERT_EQUAL(TRIBO_ERR_PAPER_SAMPLE_TIME, refused(&config));
    config           = rig(1.0f);
    config.arm_lag_s = 0.0f; // none that is known
    TEST_ASSERT_EQUAL(TRIBO_OK, refused(&config));
    config.arm_lag_s = 1.0e-7f; // an arm of little inertia
    TEST_ASSERT_EQUAL(TRIBO_OK, refused(&config));
    config.arm_lag_s     = 0.0f;
    config.sample_time_s = 1.0e-6f;
    TEST_ASSERT_EQUAL(TRIBO_OK, refused(&config));
    TEST_ASSERT_EQUAL(TRIBO_ERR_NULL, prepare(NULL, &config));
    TEST_ASSERT_EQUAL(TRIBO_ERR_NULL, refused(NULL));
    TEST_ASSERT_EQUAL(TRIBO_ERR_NULL, init(NULL, &config));
}

static void test_before_the_init_an_axis_puts_out_nothing(void)
{
    tribo_axis_report_t report;
    axis_blob_t         blob;

    TEST_ASSERT_TRUE(TRIBO(axis, step)(&axis, to_force(0.5), to_force(0.1)) == 0);
    TEST_ASSERT_TRUE(TRIBO(axis, error)(&axis, to_force(0.5), to_force(0.1)) == 0);
    TEST_ASSERT_TRUE(TRIBO(axis, command)(&axis, to_force(0.5)) == 0);
    TEST_ASSERT_TRUE(TRIBO(axis, excess)(&axis) == 0);
#if TRIBO_IS_Q31
    TEST_ASSERT_FALSE(tribo_axis_q31_learn(&axis));
#endif
    TRIBO(axis, report)(&axis, &report);
    TEST_ASSERT_EQUAL_FLOAT(1.0f, report.share);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, report.high_n[0]);
    TEST_ASSERT_NULL(tribo_axis_warning(&report.warnings));
    TRIBO(axis, export)(&axis, &blob);
    TEST_ASSERT_EQUAL(TRIBO_ERR_AXIS_ORDER, TRIBO(axis, import)(&axis, &blob));
    TEST_ASSERT_EQUAL(TRIBO_ERR_AXIS_ORDER, TRIBO(axis, change)(&axis, &axis.params));
}

static void test_an_axis_is_the_loop_below_it(void)
{
    const tribo_axis_f32_config_t config = rig(0.8f);
    TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));

    static TRIBO(feedforward, memory_t) memory;
    TRIBO(force_loop, state_t) loop = {.memory = &memory.state.tick};
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(force_loop, start)(&loop, &axis.params.loop, false));
    plant_t plant = {0};
    for (long tick = 0; tick < 2 * PERIOD; tick++)
    {
        const tribo_force_t r = to_force(triangle(tick));
        const tribo_force_t y = tick % 500 == 499 ? to_force(FULL_SCALE_N * 10.0) : to_force(plant.reading);
        const tribo_force_t u = TRIBO(axis, step)(&axis, r, y);
        learn(&axis);
        TEST_ASSERT_TRUE(u == TRIBO(force_loop, step)(&axis.params.loop, &loop, r, y, NULL));
        (void)TRIBO(feedforward, learn)(&axis.params.loop, &memory);
        plant_step(&plant, from_force(u));
    }
    tribo_axis_report_t report;
    TRIBO(axis, report)(&axis, &report);
    TEST_ASSERT_EQUAL(loop.bad_inputs, report.bad_inputs);
    TEST_ASSERT_EQUAL(2 * PERIOD / 500, report.bad_inputs);
}

/// A PI by hand, with back-calculation.
static double my_pi(double *integral, double e, double excess)
{
    *integral += 27.0 * H * e + 0.5 * excess;
    return 0.5 * e + *integral;
}

/// The loop's own halves with the same controller's output, and a change of params while they run.
static void test_the_halves_and_a_change_are_those_of_the_loop(void)
{
    tribo_axis_f32_config_t config = rig(0.8f);
    static axis_params_t    other;
    config.controller = tribo_own();
    TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
    config.arm_lag_s = 0.009f;
    TEST_ASSERT_EQUAL(TRIBO_OK, prepare(&other, &config));

    static TRIBO(feedforward, memory_t) memory;
    TRIBO(force_loop, state_t) loop = {.memory = &memory.state.tick};
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(force_loop, start)(&loop, &axis.params.loop, false));
    plant_t plant    = {0};
    double  integral = 0.0;
    for (long tick = 0; tick < 2 * PERIOD; tick++)
    {
        const axis_params_t *const params = tick / 1000 % 2 == 0 ? &axis.params : &other;
        if (params != axis.active)
        {
            TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(axis, change)(&axis, params));
        }
        tribo_force_t       excess;
        const tribo_force_t r = to_force(tick % 700 == 0 ? FULL_SCALE_N * 10.0 : triangle(tick));
        const tribo_force_t y = tick % 500 == 0 ? to_force(FULL_SCALE_N * 10.0) : to_force(plant.reading);
        const tribo_force_t e = TRIBO(axis, error)(&axis, r, y);
        TEST_ASSERT_TRUE(e == TRIBO(force_loop, error)(&params->loop, &loop, r, y));
        const double        own = my_pi(&integral, from_force(e), from_force(TRIBO(axis, excess)(&axis)));
        const tribo_force_t v   = to_force(tick % 997 == 0 ? 1.5 : own); // beyond the limit
        const tribo_force_t u   = TRIBO(axis, command)(&axis, v);
        learn(&axis);
        TEST_ASSERT_TRUE(u == TRIBO(force_loop, command)(&params->loop, &loop, v, &excess));
        TEST_ASSERT_TRUE(excess == TRIBO(axis, excess)(&axis));
        (void)TRIBO(feedforward, learn)(&params->loop, &memory);
        plant_step(&plant, from_force(u));
    }
}

/// tribo_pi needs less of the check, so the result of the whole check must be the same.
static void test_a_pi_is_the_section_that_the_loop_makes_of_it(void)
{
    static const float gains[][2] = {{0.5f, 27.0f}, {0.5f, 0.0f}, {0.5f, 1000.0f}, {40.0f, 0.001f}, {40.0f, 1e-6f}};
    for (uint32_t i = 0; i < sizeof gains / sizeof gains[0]; i++)
    {
        axis_params_t                    pi       = {0};
        axis_params_t                    sections = {0};
        tribo_axis_f32_config_t          config   = rig(1.0f);
        const tribo_pi_t                 gain     = {gains[i][0], gains[i][1]};
        const tribo_biquad_f32_section_t section  = tribo_pi_f32_section(&gain, config.sample_time_s);
        config.controller                         = tribo_pi(gain.kp, gain.ki_per_s);
        const tribo_status_t status               = prepare(&pi, &config);
        config.controller                         = tribo_sections(&section, 1);
        TEST_ASSERT_EQUAL(prepare(&sections, &config) == TRIBO_OK ? TRIBO_OK : TRIBO_ERR_PI, status);
        TEST_ASSERT_TRUE((status == TRIBO_OK) == (i < TRIBO_EITHER(4u, 3u)));
        TEST_ASSERT_EQUAL_MEMORY(&sections.loop.controller, &pi.loop.controller, sizeof pi.loop.controller);
    }
    tribo_axis_f32_config_t config = rig(1.0f);
    config.controller              = tribo_paper();
    config.controller.make         = NULL; // not from one of the functions
    TEST_ASSERT_EQUAL(TRIBO_ERR_CONTROLLER, refused(&config));
}

static void test_what_compensation_saves_is_not_exaggerated(void)
{
    double                        jump;
    plant_t                       plant  = {0};
    const tribo_axis_f32_config_t config = rig(0.3f); // the controller overcomes the first reversal
    tribo_axis_report_t           report;
    TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
    (void)run(&axis, &plant, 0, PERIOD * 4 / 10, &jump);
    TRIBO(axis, report)(&axis, &report);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, report.times_less);
    (void)run(&axis, &plant, PERIOD * 4 / 10, PERIOD * 9 / 10, &jump);
    TRIBO(axis, report)(&axis, &report);
    TEST_ASSERT_TRUE(report.times_less >= 0.25f && report.times_less < 1.5f);
    (void)run(&axis, &plant, PERIOD * 9 / 10, 40 * PERIOD, &jump);
    TRIBO(axis, report)(&axis, &report);
    TEST_ASSERT_TRUE(report.times_less > 5.0f && report.times_less < 20.0f);

    axis.feedforward.learner.ratio = 1e-4f; // less than the monitor can see
    TRIBO(axis, report)(&axis, &report);
    TEST_ASSERT_EQUAL_FLOAT(100.0f, report.times_less);
    axis.feedforward.learner.left = 1; // friction is fed back
    TRIBO(axis, report)(&axis, &report);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, report.times_less);
    TRIBO(axis, restore)(&axis); // judges anew
    TRIBO(axis, report)(&axis, &report);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, report.times_less);
}

static void test_friction_is_gone_and_its_interval_holds_it(void)
{
    const float beliefs[] = {0.7f, 1.0f, 1.3f};
    for (uint32_t i = 0; i < 3; i++)
    {
        double                        jump;
        plant_t                       plant  = {0};
        const tribo_axis_f32_config_t config = rig(beliefs[i]);
        TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
        tribo_axis_report_t first;
        TRIBO(axis, report)(&axis, &first);
        (void)run(&axis, &plant, 0, 4 * PERIOD, &jump);
        const double error = run(&axis, &plant, 4 * PERIOD, 5 * PERIOD, &jump);

        tribo_axis_report_t report;
        TRIBO(axis, report)(&axis, &report);
        ASSERT_BELOW(1.5e-3, error);
        TEST_ASSERT_EQUAL(0, report.warnings);
        ASSERT_ABOVE(2.0, (double)report.times_less);
        TEST_ASSERT_EQUAL_FLOAT(1.0f, report.share);
        ASSERT_ABOVE(1.0, (double)report.travel_n);
        const double truth = 0.03 + 0.3 * 0.25; // at a quarter of the limit
        for (uint32_t direction = 0; direction < 2; direction++)
        {
            TEST_ASSERT_TRUE((double)report.low_n[direction] < truth && truth < (double)report.high_n[direction]);
            TEST_ASSERT_TRUE(report.low_n[direction] < report.breakaway_n[direction]);
            const float before = first.high_n[direction] - first.low_n[direction];
            TEST_ASSERT_TRUE(report.high_n[direction] - report.low_n[direction] < 0.5f * before);
        }
    }
}

static void test_a_controller_of_the_callers_stays_in_place(void)
{
    tribo_axis_f32_config_t config = rig(1.0f);
    config.controller              = tribo_own();
    TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
    plant_t plant    = {0};
    double  integral = 0.0;
    double  sum      = 0.0;
    for (long tick = 0; tick < 5 * PERIOD; tick++)
    {
        const double r = triangle(tick);
        const double e = from_force(TRIBO(axis, error)(&axis, to_force(r), to_force(plant.reading)));
        const double v = my_pi(&integral, e, from_force(TRIBO(axis, excess)(&axis)));
        plant_step(&plant, from_force(TRIBO(axis, command)(&axis, to_force(v))));
        learn(&axis);
        sum += tick < 4 * PERIOD ? 0.0 : (r - plant.force) * (r - plant.force);
    }
    ASSERT_BELOW(1.5e-3, sqrt(sum / PERIOD));
}

static void test_the_limit_is_told_to_the_callers_controller(void)
{
    tribo_axis_f32_config_t config = rig(1.0f);
    config.controller              = tribo_own();
    TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
    (void)TRIBO(axis, error)(&axis, 0, 0);
    const double inside = from_force(TRIBO(axis, command)(&axis, to_force(0.25)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.25, inside);
    TEST_ASSERT_TRUE(TRIBO(axis, excess)(&axis) == 0);
    (void)TRIBO(axis, error)(&axis, 0, 0);
    TEST_ASSERT_TRUE(TRIBO(axis, command)(&axis, to_force(1.5)) == axis.params.loop.controller.TRIBO_N(u_max));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -0.5, from_force(TRIBO(axis, excess)(&axis)));
    tribo_axis_report_t report;
    TRIBO(axis, report)(&axis, &report);
    TEST_ASSERT_EQUAL(1, report.limited_ticks);
#if !TRIBO_IS_Q31
    const float bad[] = {NAN, INFINITY, -INFINITY, 1e30f};
    for (uint32_t i = 0; i < 4; i++)
    {
        (void)TRIBO(axis, error)(&axis, 0, 0);
        TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.0f, TRIBO(axis, command)(&axis, bad[i]));
    }
    TRIBO(axis, report)(&axis, &report);
    TEST_ASSERT_EQUAL(4, report.bad_inputs);
#endif
}

static void test_a_loop_without_a_method_has_a_callers_controller_alone(void)
{
    TRIBO(force_loop, params_t) params;
    TRIBO(force_loop, state_t) state;
    tribo_point_t                       table[TRIBO_BREAKAWAY_POINTS_MAX];
    const tribo_force_loop_f32_config_t config = tribo_force_loop_f32_paper();
    TEST_ASSERT_EQUAL(TRIBO_OK, tribo_init_loop(&params, table, &config, (float)FULL_SCALE_N));
    (void)TRIBO(force_loop, start)(&state, &params, false);
    tribo_force_t excess = 1;
    TEST_ASSERT_DOUBLE_WITHIN(1e-6,
                              0.25,
                              from_force(TRIBO(force_loop, error)(&params, &state, to_force(0.5), to_force(0.25))));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6,
                              0.25,
                              from_force(TRIBO(force_loop, command)(&params, &state, to_force(0.25), &excess)));
    TEST_ASSERT_TRUE(excess == 0);
    TEST_ASSERT_EQUAL_PTR(&params, state.active);
}

static void test_another_config_does_not_bump_and_keeps_what_is_learned(void)
{
    double                  jump;
    plant_t                 plant  = {0};
    tribo_axis_f32_config_t config = rig(0.7f);
    static axis_params_t    next;
    TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
    TEST_ASSERT_EQUAL(TRIBO_ERR_AXIS_ORDER, TRIBO(axis, change)(&axis, &next));
    TEST_ASSERT_EQUAL(TRIBO_ERR_NULL, TRIBO(axis, change)(&axis, NULL));
    TEST_ASSERT_EQUAL(TRIBO_ERR_NULL, TRIBO(axis, change)(NULL, &next));
    const double        usual = run_to_a_straight(&plant);
    tribo_axis_report_t before;
    TRIBO(axis, report)(&axis, &before);

    config.sample_time_s = 0.5f * config.sample_time_s;
    TEST_ASSERT_EQUAL(TRIBO_OK, prepare(&next, &config));
    TEST_ASSERT_EQUAL(TRIBO_ERR_SAMPLE_TIME, TRIBO(axis, change)(&axis, &next));
    config.sample_time_s = (float)H;
    config.controller    = tribo_pi(0.3f, 15.0f);
    TEST_ASSERT_EQUAL(TRIBO_OK, prepare(&next, &config));
    next.full_scale_n *= 2.0f;
    TEST_ASSERT_EQUAL(TRIBO_ERR_FULL_SCALE, TRIBO(axis, change)(&axis, &next));
    next.full_scale_n *= 0.5f;
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(axis, change)(&axis, &next));
    TEST_ASSERT_EQUAL(TRIBO_ERR_AXIS_ORDER, TRIBO(axis, change)(&axis, &next)); // in use
    (void)run(&axis, &plant, 4 * PERIOD + 500, 4 * PERIOD + 700, &jump);
    ASSERT_BELOW(2.0 * usual + 1e-5, jump);

    tribo_axis_report_t after;
    TRIBO(axis, report)(&axis, &after);
    TEST_ASSERT_FLOAT_WITHIN(0.01f * before.breakaway_n[0], before.breakaway_n[0], after.breakaway_n[0]);
    (void)run(&axis, &plant, 4 * PERIOD + 700, 6 * PERIOD, &jump);
    ASSERT_BELOW(2.5e-3, run(&axis, &plant, 6 * PERIOD, 7 * PERIOD, &jump));
}

/// What was learned refers to the configured breakaway and load, so it would be wrong beside others.
static void test_another_breakaway_load_or_presliding_forgets_what_was_learned(void)
{
    for (int of = 0; of < 4; of++)
    {
        double               jump;
        plant_t              plant = {0};
        static axis_params_t next;
        tribo_axis_report_t  before;
        tribo_axis_report_t  after;

        tribo_axis_f32_config_t config  = rig(0.7f);
        config.feedforward.presliding_n = 0.015f;
        config.negative                 = (tribo_breakaway_f32_t){0.021f, 0.25f};
        TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
        const double usual             = run_to_a_straight(&plant);
        axis.feedforward.late          = 3;
        axis.feedforward.forgotten     = 4;
        axis.feedforward.learner.harms = 1;
        axis.is_far_below              = 1;
        TRIBO(axis, report)(&axis, &before);
        config.gravity_n                = of == 0 ? 0.01f : 0.0f;
        config.positive.offset_n        = of == 1 ? 0.025f : 0.021f;
        config.feedforward.presliding_n = of == 2 ? 0.02f : 0.015f;
        if (of == 3) // the same in both directions together
        {
            const float slope     = config.positive.slope;
            config.positive.slope = config.negative.slope;
            config.negative.slope = slope;
        }
        TEST_ASSERT_EQUAL(TRIBO_OK, prepare(&next, &config));
        TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(axis, change)(&axis, &next));
        TRIBO(axis, report)(&axis, &after);
        TEST_ASSERT_TRUE(before.travel_n > 0.0f && after.travel_n == 0.0f);
        TEST_ASSERT_TRUE(before.breakaway_factor == 3.0f && after.breakaway_factor == 1.0f);
        TEST_ASSERT_EQUAL(3, after.late);
        TEST_ASSERT_EQUAL(4, after.forgotten);
        TEST_ASSERT_EQUAL(0, axis.feedforward.learner.harms);
        (void)run(&axis, &plant, 4 * PERIOD + 500, 4 * PERIOD + 700, &jump);
        ASSERT_BELOW(2.0 * usual + 1e-5, jump);
    }
}

/// The axis derives the usual force as the loop does, where none is given.
static void test_the_usual_force_is_that_of_the_loop(void)
{
    const float given[] = {0.0f, 0.3f};
    for (uint32_t i = 0; i < 4u; i++)
    {
        tribo_axis_f32_config_t       config = rig(1.0f);
        tribo_force_loop_f32_config_t loop   = {.usual_force_n = given[i / 2u]};
        axis_params_t                 params;
        config.usual_force_n = given[i / 2u];
        *(i % 2u == 0u ? &config.u_min_n : &config.u_max_n) *= 0.5f;
        loop.controller.u_min_n = config.u_min_n;
        loop.controller.u_max_n = config.u_max_n;
        TEST_ASSERT_EQUAL(TRIBO_OK, prepare(&params, &config));
        TEST_ASSERT_EQUAL_FLOAT(tribo_force_loop_f32_usual_force_n(&loop), params.usual_force_n);
    }
}

/// The learned load is held in units of the breakaway at the usual force. Another usual force leaves it as it is.
static void test_another_usual_force_keeps_the_learned_load(void)
{
    double                  jump;
    plant_t                 plant = {0};
    static axis_params_t    next;
    tribo_axis_report_t     before;
    tribo_axis_report_t     after;
    tribo_axis_f32_config_t config = rig(1.0f);
    config.negative                = (tribo_breakaway_f32_t){0.05f, 0.3f}; // a load of 0.01 N, which is not there
    config.usual_force_n           = 0.3f;
    TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
    (void)run(&axis, &plant, 0, 4 * PERIOD, &jump);
    TRIBO(axis, report)(&axis, &before);
    config.usual_force_n = 0.1f;
    TEST_ASSERT_EQUAL(TRIBO_OK, prepare(&next, &config));
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(axis, change)(&axis, &next));
    next.usual_force_n = axis.params.usual_force_n; // both reports at the same force
    TRIBO(axis, report)(&axis, &after);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, before.breakaway_n[0], after.breakaway_n[0]);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, before.breakaway_n[1], after.breakaway_n[1]);
    TEST_ASSERT_TRUE(fabsf(before.breakaway_n[0] - 0.12f) < 0.01f);
}

/// The first tick after a time without ticks is like the first one of all, but for what was learned.
static void test_an_axis_that_rests_starts_from_rest_with_what_it_has_learned(void)
{
    const tribo_axis_f32_config_t config = rig(0.7f);
    tribo_axis_report_t           before;
    tribo_axis_report_t           after;
    double                        jump;
    for (int rests = 0; rests < 2; rests++)
    {
        plant_t plant = {0};
        TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
        TRIBO(axis, rest)(&axis);
        (void)run(&axis, &plant, 0, 3 * PERIOD + PERIOD / 2, &jump);
        TRIBO(axis, report)(&axis, &before);
        if (rests != 0)
        {
            TRIBO(axis, rest)(&axis);
        }
        const double u = fabs(from_force(TRIBO(axis, step)(&axis, to_force(0.0), to_force(0.0))));
        TEST_ASSERT_TRUE(rests != 0 ? u < 0.03 : u > 0.15);
        TRIBO(axis, report)(&axis, &after);
        TEST_ASSERT_FLOAT_WITHIN(1e-2f, before.travel_n, after.travel_n);
        TEST_ASSERT_EQUAL(before.limited_ticks, after.limited_ticks);
    }
}

static void test_a_tick_in_the_way_of_another_controller_is_a_warning(void)
{
    for (int is_own = 0; is_own < 2; is_own++)
    {
        for (int halves = 0; halves < 2; halves++)
        {
            tribo_axis_f32_config_t config = rig(1.0f);
            tribo_axis_report_t     seen;
            config.controller = is_own != 0 ? tribo_own() : config.controller;
            TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
            if (halves != 0)
            {
                (void)TRIBO(axis, command)(&axis, TRIBO(axis, error)(&axis, 0, 0));
            }
            else
            {
                (void)TRIBO(axis, step)(&axis, 0, 0);
            }
            TRIBO(axis, report)(&axis, &seen);
            const char *const said = tribo_axis_warning(&seen.warnings);
            TEST_ASSERT_TRUE((said != NULL) == (is_own != halves));
            TEST_ASSERT_TRUE(said == NULL || strncmp(said, "calls: ", 7) == 0);
            TRIBO(axis, restore)(&axis);
            TRIBO(axis, report)(&axis, &seen);
            TEST_ASSERT_EQUAL_UINT32(0, seen.warnings);
        }
    }
}

static void test_a_second_half_without_a_first_is_a_warning(void)
{
    tribo_axis_f32_config_t config = rig(1.0f);
    tribo_axis_report_t     seen;
    config.controller = tribo_own();
    TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
    (void)TRIBO(axis, command)(&axis, TRIBO(axis, error)(&axis, 0, 0));
    TRIBO(axis, report)(&axis, &seen);
    TEST_ASSERT_EQUAL_UINT32(0, seen.warnings);
    (void)TRIBO(axis, command)(&axis, 0);
    TRIBO(axis, report)(&axis, &seen);
    TEST_ASSERT_EQUAL_INT(0, strncmp(tribo_axis_warning(&seen.warnings), "calls: ", 7));
}

/// r and u move by some mN a tick under a stiff PI, which would answer another error with a jump.
static void test_u_goes_on_when_learned_values_come_or_go_while_r_moves_fast(void)
{
    static axis_params_t next;
    axis_blob_t          blob;
    for (int of = 0; of < 2; of++)
    {
        double                  usual  = 0.0;
        plant_t                 plant  = {0};
        tribo_axis_f32_config_t config = rig(0.7f);
        config.controller              = tribo_pi(2.0f, 80.0f);
        TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
        for (int tick = 0; tick <= 20100; tick++)
        {
            if (tick == 20100)
            {
                TRIBO(axis, export)(&axis, &blob);
                config.gravity_n += 1e-6f;
                TEST_ASSERT_EQUAL(TRIBO_OK, prepare(&next, &config));
                TEST_ASSERT_EQUAL(TRIBO_OK,
                                  of != 0 ? TRIBO(axis, import)(&axis, &blob) : TRIBO(axis, change)(&axis, &next));
            }
            const double r = 0.35 + 0.25 * sin(6.283185307 * tick * H);
            const double u = from_force(TRIBO(axis, step)(&axis, to_force(r), to_force(plant.reading)));
            learn(&axis);
            if (tick == 20100)
            {
                ASSERT_BELOW(2.0 * usual, fabs(u - plant.u));
            }
            usual   = tick > 20000 ? fmax(usual, fabs(u - plant.u)) : 0.0;
            plant.u = u;
            plant_step(&plant, u);
        }
    }
}

static void test_what_is_learned_outlives_a_loss_of_power(void)
{
    double                        jump;
    double                        usual;
    plant_t                       plant  = {0};
    const tribo_axis_f32_config_t config = rig(0.7f);
    TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
    (void)run(&axis, &plant, 0, 4 * PERIOD + 300, &jump);
    axis_blob_t         blob;
    tribo_axis_report_t before;
    tribo_axis_report_t after;
    TRIBO(axis, export)(&axis, &blob);
    TRIBO(axis, report)(&axis, &before);

    TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
    TRIBO(axis, report)(&axis, &after);
    TEST_ASSERT_TRUE(before.breakaway_n[0] > 1.1f * after.breakaway_n[0]);
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(axis, import)(&axis, &blob));
    TRIBO(axis, report)(&axis, &after);
    TEST_ASSERT_EQUAL_FLOAT(before.breakaway_n[0], after.breakaway_n[0]);
    TEST_ASSERT_FLOAT_WITHIN(0.05f * before.low_n[1], before.low_n[1], after.low_n[1]); // at no sample's force now

    // Into an axis that runs: u goes on. With another controller at once it does, too.
    (void)run(&axis, &plant, 4 * PERIOD + 300, 4 * PERIOD + 500, &jump);
    (void)run(&axis, &plant, 4 * PERIOD + 500, 4 * PERIOD + 600, &usual);
    axis.feedforward.learner.harms = 1;
    axis.is_far_below              = 1;
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(axis, import)(&axis, &blob));
    TRIBO(axis, report)(&axis, &after);
    TEST_ASSERT_EQUAL_UINT32(0, after.warnings);
    (void)run(&axis, &plant, 4 * PERIOD + 600, 4 * PERIOD + 700, &jump);
    ASSERT_BELOW(1.5 * usual + 1e-5, jump);
    static axis_params_t    next;
    tribo_axis_f32_config_t softer = config;
    softer.controller              = tribo_pi(0.4f, 20.0f);
    TEST_ASSERT_EQUAL(TRIBO_OK, prepare(&next, &softer));
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(axis, import)(&axis, &blob));
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(axis, change)(&axis, &next));
    (void)run(&axis, &plant, 4 * PERIOD + 700, 4 * PERIOD + 800, &jump);
    ASSERT_BELOW(3.0 * usual + 1e-4, jump);
    TRIBO(axis, report)(&axis, &after);
    TEST_ASSERT_EQUAL(0, after.forgotten);
}

static void test_a_blob_with_a_flipped_bit_is_refused(void)
{
    double                  jump;
    plant_t                 plant  = {0};
    tribo_axis_f32_config_t config = rig(0.7f);
    axis_blob_t             blob;
    TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
    (void)run(&axis, &plant, 0, PERIOD, &jump);
    TRIBO(axis, export)(&axis, &blob);
    const axis_t before = axis;
    for (size_t bit = 0; bit < 8u * sizeof blob; bit++)
    {
        unsigned char *const byte = (unsigned char *)&blob + bit / 8u;
        *byte                     = (unsigned char)(*byte ^ (1u << bit % 8u));
        TEST_ASSERT_EQUAL(bit < 32u ? TRIBO_ERR_BLOB_VERSION : TRIBO_ERR_BLOB_CHECKSUM,
                          TRIBO(axis, import)(&axis, &blob));
        *byte = (unsigned char)(*byte ^ (1u << bit % 8u));
    }
    TEST_ASSERT_EQUAL(TRIBO_ERR_NULL, TRIBO(axis, import)(&axis, NULL));
    TEST_ASSERT_EQUAL(TRIBO_ERR_NULL, TRIBO(axis, import)(NULL, &blob));
    TEST_ASSERT_EQUAL_MEMORY(&before, &axis, sizeof axis);
    config.gravity_n = -0.0f;
    TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(axis, import)(&axis, &blob));
    config.negative = (tribo_breakaway_f32_t){0.03f, 0.2f};
    TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
    TEST_ASSERT_EQUAL(TRIBO_ERR_BLOB_RIG, TRIBO(axis, import)(&axis, &blob));
}

static void test_each_warning_has_a_sentence_and_a_command_clears_what_is_latched(void)
{
    const tribo_axis_f32_config_t config = rig(1.0f);
    TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
    tribo_axis_report_t report;
    axis.guard.cause              = TRIBO_GUARD_HUNTING;
    axis.is_far_below             = 1;
    axis.feedforward.forgotten    = 1;
    axis.bad_inputs               = 1;
    axis.controller.limited_ticks = 1;
    TRIBO(axis, report)(&axis, &report);
    for (uint32_t i = 0; i < 5; i++)
    {
        const char *const text = tribo_axis_warning(&report.warnings);
        TEST_ASSERT_NOT_NULL(text);
        TEST_ASSERT_TRUE(strlen(text) > 20);
    }
    TEST_ASSERT_NULL(tribo_axis_warning(&report.warnings));

    axis.guard.cause = TRIBO_GUARD_OVERSHOOT;
    TRIBO(axis, report)(&axis, &report);
    uint32_t guards = report.warnings & ~7u; // behind those of inputs and limits
    TEST_ASSERT_NOT_NULL(strstr(tribo_axis_warning(&guards), "overshot"));
    TRIBO(axis, restore)(&axis);
    TRIBO(axis, report)(&axis, &report);
    (void)tribo_axis_warning(&report.warnings);
    (void)tribo_axis_warning(&report.warnings);
    TEST_ASSERT_NOT_NULL(strstr(tribo_axis_warning(&report.warnings), "corrupt"));
    TEST_ASSERT_NULL(tribo_axis_warning(&report.warnings));
}

/// The texts of all warnings of `x`, one after the other.
static const char *texts_of(const axis_t *x)
{
    static char         all[2000];
    tribo_axis_report_t report;
    TRIBO(axis, report)(x, &report);
    all[0] = 0;
    for (const char *text = tribo_axis_warning(&report.warnings); text != NULL;
         text             = tribo_axis_warning(&report.warnings))
    {
        TEST_ASSERT_TRUE(strlen(all) + strlen(text) + 2u < sizeof all);
        strcat(all, text);
        strcat(all, "\n");
    }
    return all;
}

static void test_a_breakaway_far_from_the_rigs_is_named_with_its_direction(void)
{
    static const struct
    {
        float       belief, factor;
        const char *says;
    } cases[] = {{0.03f, 3.0f, "3 times the breakaway"},
                 {0.05f, 3.0f, "3 times the breakaway"},
                 {0.1f, 3.0f, "3 times the breakaway"},
                 {0.2f, 3.0f, "3 times the breakaway"},
                 {0.6f, 1.0f, NULL},
                 {1.0f, 1.0f, NULL},
                 {2.5f, 1.0f, NULL},
                 {8.0f, 0.2f, "configure 0.2 times"}};
    for (uint32_t i = RUNS(0, 1); i < sizeof cases / sizeof cases[0]; i += RUNS(1, 2))
    {
        double                        jump;
        plant_t                       plant  = {0};
        const tribo_axis_f32_config_t config = rig(cases[i].belief);
        tribo_axis_report_t           report;
        TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
        (void)run(&axis, &plant, 0, 8 * PERIOD, &jump);
        TRIBO(axis, report)(&axis, &report);
        TEST_ASSERT_EQUAL_FLOAT(cases[i].factor, report.breakaway_factor);
        TEST_ASSERT_TRUE((report.high_n[0] == 1e6f && report.high_n[1] == 1e6f) == (cases[i].factor == 3.0f));
        const char *const texts = texts_of(&axis);
        TEST_ASSERT_TRUE(cases[i].says != NULL ? strstr(texts, cases[i].says) != NULL
                                               : strstr(texts, "breakaway:") == NULL);
        TRIBO(axis, restore)(&axis);
        TRIBO(axis, report)(&axis, &report);
        TEST_ASSERT_EQUAL_FLOAT(cases[i].factor == 3.0f ? 1.0f : cases[i].factor,
                                report.breakaway_factor); // 3 is latched
    }
}

/// What the learner says counts only once slides both ways have settled friction, and while there is enough of it.
static void test_a_warning_of_the_learner_needs_settled_friction(void)
{
    static const struct
    {
        float       variance, sliding, presliding; ///< P_00, V_0, V_2
        const char *says;
    } cases[]                            = {{0.05f, 1.0f, 1.3f, "double presliding_n"},
                                            {0.05f, 1.0f, -0.2f, "halve presliding_n"},
                                            {0.05f, 1.0f, 1.0f, NULL},
                                            {0.3f, 1.0f, 1.3f, NULL},
                                            {0.3f, 1.0f, -0.2f, NULL},
                                            {0.05f, 0.3f, 0.5f, NULL},
                                            {0.05f, 0.3f, -0.2f, NULL}};
    const tribo_axis_f32_config_t config = rig(1.0f);
    TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
    tribo_feedforward_learner_t *const        learner  = &axis.feedforward.learner;
    const tribo_feedforward_learning_t *const learning = &axis.params.feedforward.learning;
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
    {
        learner->P[0]    = cases[i].variance;
        learner->a[0]    = (cases[i].sliding - 1.0f) / learning->deviation[0];
        learner->a[2]    = cases[i].presliding / learning->deviation[2];
        axis.guard.cause = TRIBO_GUARD_NONE;
        TEST_ASSERT_EQUAL_STRING("", texts_of(&axis));
        axis.guard.cause        = TRIBO_GUARD_OVERSHOOT;
        const char *const texts = texts_of(&axis);
        TEST_ASSERT_NOT_NULL(strstr(texts, "overshot"));
        TEST_ASSERT_TRUE(cases[i].says != NULL ? strstr(texts, cases[i].says) != NULL
                                               : strstr(texts, "presliding:") == NULL);
    }
}

/// Latches of a bound and of harm outlive their causes. Lost contact leaves V_0 low, but V_2 large.
static void test_what_is_only_latched_is_no_warning(void)
{
    static const struct
    {
        float variance, sliding, presliding, factor; ///< P_00, V_0, V_2
    } cases[]                            = {{0.1f, 0.2f, 0.1f, 0.2f},
                                            {0.1f, 0.2f, 0.2f, 1.0f},
                                            {0.1f, 0.2f, -0.2f, 1.0f},
                                            {0.3f, 0.2f, 0.1f, 1.0f},
                                            {0.1f, 0.7f, 0.1f, 1.0f}};
    const tribo_axis_f32_config_t config = rig(1.0f);
    TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
    tribo_feedforward_learner_t *const learner = &axis.feedforward.learner;
    learner->harms                             = 1;
    learner->at_bound                          = TRIBO_FEEDFORWARD_BOUND_TURNS;
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
    {
        tribo_axis_report_t report;
        learner->P[0] = cases[i].variance;
        learner->a[0] = (cases[i].sliding - 1.0f) / axis.params.feedforward.learning.deviation[0];
        learner->a[2] = cases[i].presliding / axis.params.feedforward.learning.deviation[2];
        TRIBO(axis, report)(&axis, &report);
        TEST_ASSERT_EQUAL_FLOAT(cases[i].factor, report.breakaway_factor);
        TEST_ASSERT_TRUE((strstr(texts_of(&axis), "learning stays below") != NULL) == (report.warnings != 0u));
        TEST_ASSERT_TRUE((report.warnings != 0u) == (cases[i].factor != 1.0f));
    }
}

/// Follows breakaway_factor, each time with a new axis, from a twentieth and from ten times the truth.
static void test_the_factor_leads_to_a_breakaway_that_fits(void)
{
    for (uint32_t i = 0; i < RUNS(2u, 1u); i++)
    {
        float    belief = i == 0u ? 0.05f : 10.0f;
        uint32_t steps  = 0;
        for (float factor = 0.0f; factor != 1.0f && steps < 5u; steps++)
        {
            double                        jump;
            plant_t                       plant  = {0};
            const tribo_axis_f32_config_t config = rig(belief);
            tribo_axis_report_t           report;
            TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
            (void)run(&axis, &plant, 0, 8 * PERIOD, &jump);
            TRIBO(axis, report)(&axis, &report);
            factor = report.breakaway_factor;
            belief *= factor;
        }
        TEST_ASSERT_TRUE(steps < 5u && belief > 0.3f && belief < 3.5f);
    }
}

/// An arm of 30 um stroke whose friction builds up over 5 um as in Dahl's model, with exact params but for presliding.
static double run_dahl(float presliding_n)
{
    const double            delta     = 5.0;
    const double            stiffness = 0.25 / 30.0; // N/um
    tribo_axis_f32_config_t config    = rig(1.0f);
    config.feedforward.presliding_n   = presliding_n;
    TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
    double u_a = 0.0, x = 0.0, z = 0.0, y = 0.0, sum = 0.0;
    for (long tick = 0; tick < 10 * PERIOD; tick++)
    {
        const double r = triangle(tick);
        const double u = from_force(TRIBO(axis, step)(&axis, to_force(r), to_force(y)));
        learn(&axis);
        for (int i = 0; i < 25; i++)
        {
            const double dt   = H / 25;
            const double bond = (0.03 + 0.3 * stiffness * fabs(x)) / delta;
            u_a += 200.0 * dt * (u - u_a);
            const double speed = (u_a - stiffness * x - bond * z) / (0.0075 * stiffness + (stiffness + bond) * dt);
            z += dt * speed * (speed * z > 0.0 ? 1.0 - fabs(z) / delta : 1.0);
            x += dt * speed;
            y += 55.0 * dt * (stiffness * x - y);
        }
        sum += tick < 9 * PERIOD ? 0.0 : (r - stiffness * x) * (r - stiffness * x);
    }
    return sqrt(sum / PERIOD);
}

static void test_presliding_that_trips_the_guard_is_named_and_its_advice_helps(void)
{
    const float breakaway_n = 0.105f; // at a quarter of the limit
    float       presliding  = breakaway_n / 11.0f;
    ASSERT_ABOVE(2.0e-3, run_dahl(0.0f));
    TEST_ASSERT_NOT_NULL(strstr(texts_of(&axis), "guard: friction faded"));
    TEST_ASSERT_NOT_NULL(strstr(texts_of(&axis), "longer travel than configured: double presliding_n"));
    double error = 1.0;
    for (uint32_t i = 0; i < 3u && strstr(texts_of(&axis), "double presliding_n") != NULL; i++)
    {
        presliding *= 2.0f;
        error = run_dahl(presliding);
    }
    ASSERT_BELOW(1.0e-3, error);
    TEST_ASSERT_NULL(strstr(texts_of(&axis), "guard"));

    // Four times too long.
    ASSERT_ABOVE(2.0e-3, run_dahl(4.0f * 0.0417f));
    TEST_ASSERT_NOT_NULL(strstr(texts_of(&axis), "halve presliding_n"));
    ASSERT_BELOW(1.0e-3, run_dahl(2.0f * 0.0417f));
    TEST_ASSERT_EQUAL_STRING("", texts_of(&axis));
}

static void test_a_learner_that_is_never_called_is_a_warning(void)
{
    const tribo_axis_f32_config_t config = rig(1.0f);
    tribo_axis_report_t           report;
    TEST_ASSERT_EQUAL(TRIBO_OK, init(&axis, &config));
    axis.feedforward.late = 1;
    TRIBO(axis, report)(&axis, &report);
    TEST_ASSERT_NOT_NULL(strstr(tribo_axis_warning(&report.warnings), "tribo_axis_q31_learn"));
    axis.feedforward.learner.travel_n = 1.0f; // late, but it learns
    TRIBO(axis, report)(&axis, &report);
    TEST_ASSERT_EQUAL_UINT32(0, report.warnings);
}

static double draw(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 40) / 16777216.0;
}

static float spread(uint64_t *state, double low, double high)
{
    return (float)(low * pow(high / low, draw(state)));
}

/// A config within the documented ranges: forces within 30 of the limits of u, which are 1e-6 to 1e6 N.
static tribo_axis_f32_config_t legal(uint64_t *state)
{
    tribo_axis_f32_config_t config             = tribo_axis_f32_config();
    const double            u                  = (double)spread(state, 1e-6, 1e6);
    config.sample_time_s                       = spread(state, 1e-6, 0.1);
    config.u_max_n                             = (float)u;
    config.u_min_n                             = draw(state) < 0.5 ? 0.0f : -config.u_max_n;
    config.positive.offset_n                   = fmaxf(1e-6f, fminf(1e6f, spread(state, u / 30, 30 * u)));
    config.positive.slope                      = draw(state) < 0.5 ? 0.0f : spread(state, 1e-3, 10.0);
    config.gravity_n                           = draw(state) < 0.5 ? 0.0f : fminf(1e6f, spread(state, u / 30, 30 * u));
    config.noise_n                             = draw(state) < 0.3 ? 0.0f : fminf(1e6f, spread(state, u / 1e6, 30 * u));
    config.arm_lag_s                           = spread(state, 1e-3, 1e3) * config.sample_time_s;
    config.feedforward.actuator_pole_rad_per_s = fminf(1e6f, spread(state, 1e-3, 50.0) / config.sample_time_s);
    config.feedforward.sensor_pole_rad_per_s   = fminf(1e6f, spread(state, 1e-3, 50.0) / config.sample_time_s);
    const float kp                             = spread(state, 1e-6, 1e5);
    config.controller                          = tribo_pi(kp, kp * spread(state, 1e-9, 1.9) / config.sample_time_s);
    config.controller.ki_per_s                 = fminf(1e5f, config.controller.ki_per_s);
    return config;
}

/// A refusal of a legal config is about a field of an axis' config, not about one that follows from others.
static void test_a_refusal_names_a_field_of_the_config(void)
{
    uint64_t state = 5;
    uint32_t taken = 0;
    for (uint32_t i = 0; i < 3000; i++)
    {
        const tribo_axis_f32_config_t config = legal(&state);
        static axis_params_t          params;
        const float                   scale =
            fmaxf(fmaxf(4.0f * config.u_max_n, 2.0f * config.gravity_n), fmaxf(2.0f * config.positive.offset_n, 1e-3f));
        (void)scale;
        const tribo_status_t status = TRIBO_EITHER(TRIBO(axis, prepare)(&params, &config),
                                                   TRIBO(axis, prepare)(&params, &config, fminf(1e6f, scale)));
        taken += status == TRIBO_OK ? 1u : 0u;
        const bool is_own = status == TRIBO_OK || status == TRIBO_ERR_PI;
        TEST_ASSERT_TRUE_MESSAGE(
            is_own || (TRIBO_IS_Q31 && (status == TRIBO_ERR_GRAVITY || status == TRIBO_ERR_AXIS_BREAKAWAY ||
                                        status == TRIBO_ERR_BREAKAWAY_OFFSET)),
            tribo_status_text(status));
    }
    TEST_ASSERT_GREATER_THAN(TRIBO_EITHER(2600, 2200), taken);
}

static void test_a_derived_width_that_does_not_fit_names_the_breakaway(void)
{
    tribo_axis_f32_config_t config = rig(1.0f);
    config.positive                = (tribo_breakaway_f32_t){.offset_n = 0.001f};
    TEST_ASSERT_EQUAL(TRIBO_EITHER(TRIBO_OK, TRIBO_ERR_AXIS_BREAKAWAY), refused(&config));
    config.feedforward.presliding_n = 1e-4f;
    TEST_ASSERT_EQUAL(TRIBO_EITHER(TRIBO_OK, TRIBO_ERR_PRESLIDING), refused(&config));
    config.feedforward.presliding_n = 0.01f;
    TEST_ASSERT_EQUAL(TRIBO_OK, refused(&config));
    config.positive.offset_n = 1e-4f;
    TEST_ASSERT_EQUAL(TRIBO_EITHER(TRIBO_OK, TRIBO_ERR_AXIS_BREAKAWAY), refused(&config));
    config.feedforward.reversal_n = 1e-7f;
    TEST_ASSERT_EQUAL(TRIBO_EITHER(TRIBO_OK, TRIBO_ERR_REVERSAL_WIDTH), refused(&config));
    config                        = rig(1.0f);
    config.controller             = tribo_sections(&(tribo_biquad_f32_section_t){.b0 = 1.0f, .a1 = 1.0f}, 1);
    const tribo_status_t sections = refused(&config); // a controller of sections is named as such
    TEST_ASSERT_EQUAL(TRIBO_ERR_ANTI_WINDUP, sections);
}

static void test_the_largest_limits_are_taken(void)
{
    tribo_axis_f32_config_t config = rig(1.0f);
    config.u_min_n                 = -1e6f;
    config.u_max_n                 = 1e6f;
    tribo_axis_f32_params_t params;
    TEST_ASSERT_EQUAL(TRIBO_OK, tribo_axis_f32_prepare(&params, &config));
    TEST_ASSERT_TRUE(params.loop.input_max_n == 1e6f);
}

#if TRIBO_IS_Q31
static void test_a_usual_force_beyond_the_full_scale_is_refused(void)
{
    tribo_axis_f32_config_t config = rig(1.0f);
    axis_params_t           params;
    config.usual_force_n = 1.01f * (float)FULL_SCALE_N;
    TEST_ASSERT_EQUAL(TRIBO_ERR_USUAL_FORCE, tribo_axis_q31_prepare(&params, &config, (float)FULL_SCALE_N));
    TEST_ASSERT_EQUAL(TRIBO_ERR_FULL_SCALE, tribo_axis_q31_prepare(&params, &config, NAN));
    TEST_ASSERT_EQUAL(TRIBO_ERR_FULL_SCALE, tribo_axis_q31_prepare(&params, &config, -1.0f));
}
#endif

#if TRIBO_IS_Q31
static void test_forces_fit_the_full_scale(void)
{
    tribo_axis_f32_config_t config = rig(1.0f);
    TEST_ASSERT_EQUAL(TRIBO_ERR_FULL_SCALE, tribo_axis_q31_init(&axis, &config, NAN));
    config.u_max_n = 3.0f;
    TEST_ASSERT_EQUAL(TRIBO_ERR_U_MAX, init(&axis, &config)); // not input_max_n, which was left out
    config             = rig(1.0f);
    config.input_max_n = 3.0f;
    TEST_ASSERT_EQUAL(TRIBO_ERR_INPUT_MAX, init(&axis, &config));
}
#endif

#include "runners/test_axis.inc" // main
