// The feed-forward without a force sensor, as a method of the loop: what it adds, whose motion it opposes, that y and the
// controller have no part in u, hand-over, limits, corrupt memory; and the force that it estimates from u.

#define FULL_SCALE_N 4.0 // of Q31, so that an input beyond input_max shows as such
#include ARITH_HEADER
#include "random.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define H     1e-3
#define L0    0.007 // the paper's breakaway
#define L1    0.3
#define TAU   (1.0 / 200.0 + 0.0288 / 3.84)
#define WHOLE TRIBO_EITHER(1.0, 536870912.0) // of a width
#define CLOSE TRIBO_EITHER(2e-6, 2e-7)

typedef struct
{
    TRIBO(force_loop, params_t) params, fed; // without a sensor, with one
    TRIBO(feedforward, params_t) own, of_fed;
    TRIBO(feedforward, memory_t) memory;
    TRIBO(force_loop, state_t) state;
    TRIBO(force_loop, signals_t) signals;
    tribo_point_t table[2][TRIBO_BREAKAWAY_POINTS_MAX];
} blind_t;

static tribo_force_loop_f32_config_t  config;
static tribo_feedforward_f32_config_t method;
static tribo_sensorless_f32_config_t  sensorless;
static blind_t                        x;

static void reset(blind_t *b)
{
    memset(&b->memory, 0, sizeof b->memory);
    b->state.memory = &b->memory.state.tick;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, TRIBO(force_loop, start)(&b->state, &b->params, false));
}

static tribo_status_t init(blind_t *b)
{
    const tribo_status_t status =
        tribo_init_sensorless(&b->params, b->table[0], &b->own, &config, &method, &sensorless, (float)FULL_SCALE_N);
    if (status == TRIBO_OK)
    {
        TEST_ASSERT_EQUAL_INT(
            TRIBO_OK,
            tribo_init_feedforward(&b->fed, b->table[1], &b->of_fed, &config, &method, (float)FULL_SCALE_N));
        reset(b);
    }
    return status;
}

void setUp(void)
{
    config     = tribo_force_loop_f32_paper();
    method     = tribo_feedforward_f32_default();
    sensorless = tribo_sensorless_f32_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&x));
}

static double step(blind_t *b, const TRIBO(force_loop, params_t) * params, double r, double y)
{
    return from_force(TRIBO(force_loop, step)(params, &b->state, to_force(r), to_force(y), &b->signals));
}

static double tick(double r)
{
    return step(&x, &x.params, r, 0.0);
}

static void move(double intended, double measured)
{
    TRIBO(sensorless, motion)(&x.memory,
                              TRIBO_EITHER((float)intended, (int32_t)(intended * WHOLE)),
                              TRIBO_EITHER((float)measured, (int32_t)(measured * WHOLE)));
}

/// 0.3 to 0.5 N at 0.1 N/s, from its low end.
static double triangle(int k)
{
    const int phase = k % 4000;
    return 0.3 + 1e-4 * (phase < 2000 ? phase : 4000 - phase);
}

static void test_it_adds_the_believed_part_of_breakaway_against_the_motion_of_r(void)
{
    TEST_ASSERT_TRUE(sensorless.belief == 0.9f);
    for (int half = 0; half < 2; half++)
    {
        sensorless.belief = half != 0 ? 0.5f : 0.9f;
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&x));
        for (int k = 0; k < 12000; k++)
        {
            const double r    = triangle(k);
            const double u    = tick(r);
            const double side = k % 4000 < 2000 ? 1.0 : -1.0;
            if (k % 2000 > 200)
            {
                const double wanted = r + side * (0.1 * TAU + (double)sensorless.belief * (L0 + L1 * r));
                TEST_ASSERT_DOUBLE_WITHIN(CLOSE, wanted, u);
            }
        }
    }
}

static void test_directions_and_gravity_of_the_model_are_in_u(void)
{
    config.compensator.friction.negative.offset_n = 0.047f;
    config.compensator.friction.gravity_n         = 0.02f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&x));
    const double L    = 0.027 + 0.3 * triangle(1900);
    const double load = -0.02 - 0.02;
    double       up   = 0.0;
    for (int k = 0; k <= 1900; k++)
    {
        up = tick(triangle(k));
    }
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, triangle(1900) + 0.1 * TAU + load + 0.9 * L, up);
}

/// 508 ticks, of which r at 0.1 N/s asks for 51 mN.
static void test_a_lag_of_many_ticks_leads_as_it_should(void)
{
    method.actuator_pole_rad_per_s = 2.0f;
    method.reversal_n              = 0.5e-3f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&x));
    double u = 0.0;
    for (int k = 0; k <= 9000; k++)
    {
        u = tick(-0.4 + 1e-4 * k); // the rate has a filter of 406 ticks
    }
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.5 + 0.1 * (0.5 + 0.0288 / 3.84) + 0.9 * (L0 + L1 * 0.5), u);
}

static void test_friction_changes_its_sign_within_the_jump_time_and_its_lead_is_that_of_the_jump(void)
{
    double sum  = 0.0;
    double f    = 0.0;
    double most = 0.0;
    for (int k = 0; k < 2300; k++)
    {
        (void)tick(triangle(k));
        const double now = from_force(x.signals.compensator.friction.TRIBO_N(f));
        if (k > 1990)
        {
            sum += from_force(x.signals.TRIBO_N(friction_term)) - triangle(k) - now;
            most = fmax(most, fabs(now - f));
        }
        f = now;
    }
    const double L = 0.9 * (L0 + L1 * 0.5);
    TEST_ASSERT_DOUBLE_WITHIN(0.05 * L, 2.0 * L / 26.25, most); // 2.1 tau
    // Beside the lead, the sum has the rate of r: 10 ticks up and 300 down, behind a filter.
    const double lead = sum + 0.1 * TAU * 290.0;
    TEST_ASSERT_DOUBLE_WITHIN(0.1, -0.7 / (200.0 * H) * 2.0 * L, lead);
    TEST_ASSERT_DOUBLE_WITHIN(0.03, -L, f);
}

static void test_neither_y_nor_the_controller_has_a_part_in_u(void)
{
    static blind_t other;
    random_t       r = {.state = 0xb11dULL};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&other));
    for (int k = 0; k < 9000; k++)
    {
        const double u = tick(triangle(k));
        TEST_ASSERT_TRUE(u == step(&other, &other.params, triangle(k), random_between(&r, -3.0, 3.0)));
        TEST_ASSERT_TRUE(from_force(x.signals.controller.TRIBO_N(v)) == 0.0);
        TEST_ASSERT_TRUE(from_force(x.signals.TRIBO_N(e)) == 0.0);
    }
    TEST_ASSERT_TRUE(other.memory.state.learner.travel_n == 0.0f); // and nothing is learned
}

static void test_mirrored_references_give_mirrored_bits(void)
{
    static blind_t other;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&other));
    for (int k = 0; k < 9000; k++)
    {
        TEST_ASSERT_TRUE(tick(triangle(k)) == -step(&other, &other.params, -triangle(k), 0.0));
    }
}

static void test_friction_keeps_its_sign_while_r_stands(void)
{
    for (int k = 0; k < 1500; k++)
    {
        (void)tick(triangle(k));
    }
    double u = 0.0;
    for (int k = 0; k < 5000; k++)
    {
        u = tick(triangle(1500));
    }
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, triangle(1500) + 0.9 * (L0 + L1 * triangle(1500)), u);
}

static double friction_now(void)
{
    return from_force(x.signals.compensator.friction.TRIBO_N(f));
}

/// `count` ticks of r at 0.4 N; friction goes no faster than in a reversal of r.
static double moved(int count, double intended, double measured)
{
    double before = friction_now();
    for (int k = 0; k < count; k++)
    {
        move(intended, measured);
        (void)tick(0.4);
        const double f = friction_now();
        TEST_ASSERT_TRUE(fabs(f - before) < 0.011 * 1.3);
        before = f;
    }
    return before / (0.9 * (L0 + L1 * 0.4));
}

static void test_where_a_motion_is_known_friction_opposes_that(void)
{
    (void)tick(0.4);
    TEST_ASSERT_TRUE(moved(100, 0.0, 0.0) == 0.0);                 // none yet
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.0, moved(100, 0.05, 0.0));   // intended
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, -1.0, moved(100, -0.05, 0.0)); // and back
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, -1.0, moved(100, -0.05, 0.3)); // it goes before the measured
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.0, moved(100, 0.0, 0.05));   // which counts while the intended is at rest
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.0, moved(100, 0.0, 0.0));    // friction stays
    for (int k = 0; k < 300; k++)                                  // a measured noise below its width
    {
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.0, moved(1, 0.0, k % 2 == 0 ? -0.875 : 0.875));
    }
    for (int k = 0; k < 300; k++) // an intended one, too
    {
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.0, moved(1, k % 2 == 0 ? 0.875 : -0.875, 0.0));
    }
    for (int k = 1; k < 200; k++)
    {
        (void)tick(0.4 - 1e-4 * k); // without a word r decides
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, -0.9 * (L0 + L1 * 0.3801), friction_now());
}

/// The measured motion goes far, but the intended one counts, and it has not gone by a width yet.
static void test_an_intended_motion_below_its_width_goes_before_any_measured_one(void)
{
    (void)tick(0.4);
    TEST_ASSERT_TRUE(moved(4, 0.1, 3.5) == 0.0);
    TEST_ASSERT_TRUE(moved(4, 0.1, 0.0) > 0.0); // now it has
}

/// A noise of r by 0.6 mN, beyond the width of 0.5: a reversal is wider by four times its mean second difference.
static void test_noise_of_the_reference_widens_a_reversal(void)
{
    double r = 0.0;
    for (int k = 0; k < 20000; k++)
    {
        r = 0.3 + 1e-6 * k + (k % 10 < 5 ? 6e-4 : 0.0);
        (void)tick(r);
        TEST_ASSERT_TRUE(k < 10000 || friction_now() > 0.04); // it does not turn
    }
    int k = 0;
    while (friction_now() > 0.0)
    {
        (void)tick(r - 2e-4 * ++k);
        TEST_ASSERT_TRUE(k < 100);
    }
    TEST_ASSERT_INT_WITHIN(1, 18, k); // 1.5 mN below the peak, 0.6 of it before, and 13 ticks until friction is 0
}

static void test_a_motion_that_is_no_number_or_huge_does_no_harm(void)
{
    (void)tick(0.4);
    for (int k = 0; k < 100; k++)
    {
#if TRIBO_IS_Q31
        TRIBO(sensorless, motion)(&x.memory, INT32_MIN, INT32_MAX);
        x.memory.motion.slack[1] = INT32_MIN; // a flipped bit
#else
        TRIBO(sensorless, motion)(&x.memory, k % 2 == 0 ? NAN : -INFINITY, INFINITY);
        x.memory.motion.slack[1] = NAN;
#endif
        TEST_ASSERT_TRUE(fabs(tick(0.4)) < 1.0);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.0, moved(100, 0.5, 0.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, -1.0, moved(100, 0.0, -0.5));
}

/// The effort of another loop has no lead of its own rate: it is noise.
static void test_of_another_loops_effort_the_rate_is_not_taken(void)
{
    double u = 0.0;
    for (int k = 0; k <= 1500; k++)
    {
        move(0.1, 0.0);
        u = tick(triangle(k));
    }
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, triangle(1500) + 0.9 * (L0 + L1 * triangle(1500)), u);
}

static void test_u_stays_in_its_limits_for_any_input_and_the_controller_does_not_wind_up(void)
{
    random_t r = {.state = 0x5e5ULL};
    for (int k = 0; k < 20000; k++)
    {
        const double reference = random_between(&r, -2.2, 2.2);
        const double u         = step(&x, &x.params, reference, random_between(&r, -3.0, 3.0));
        TEST_ASSERT_TRUE(u >= -2.0 && u <= 2.0);
    }
    (void)tick(0.0);
    bool limited = false;
    for (int k = 0; k < 5000; k++)
    {
        const double u = tick(1.9);
        TEST_ASSERT_TRUE(u <= 2.0);
        limited = x.signals.controller.limited;
    }
    TEST_ASSERT_TRUE(limited);
    TEST_ASSERT_TRUE(fabs(from_force(x.signals.controller.TRIBO_N(v))) < 1e-6);
    double u = 0.0;
    for (int k = 0; k < 12000; k++)
    {
        u = tick(triangle(k));
    }
    TEST_ASSERT_FALSE(x.signals.controller.limited);
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, triangle(11999) - 0.1 * TAU - 0.9 * (L0 + L1 * triangle(11999)), u);
}

/// From a loop with a sensor and back, in the middle of a triangle, around an arm that follows u without friction.
static void test_u_goes_on_where_a_sensor_fails_or_comes_back(void)
{
    double F      = 0.3;
    double before = 0.0;
    for (int k = 0; k < 40000; k++)
    {
        const bool   blind = k >= 9500 && k < 25500;
        const double u     = step(&x, blind ? &x.params : &x.fed, triangle(k), F);
        if (k == 9500 || k == 25500)
        {
            TEST_ASSERT_DOUBLE_WITHIN(1e-3, before, u);
        }
        if (k == 25400) // by then it goes its own way
        {
            TEST_ASSERT_DOUBLE_WITHIN(2e-5, triangle(k) + 0.1 * TAU + 0.9 * (L0 + L1 * triangle(k)), u);
        }
        if (k > 39000)
        {
            TEST_ASSERT_DOUBLE_WITHIN(0.02, triangle(k), F);
        }
        before = u;
        F += 0.05 * (u - F);
    }
}

static void test_other_params_of_the_method_do_not_bump_u(void)
{
    static blind_t other;
    sensorless.belief = 0.2f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&other));
    double before = 0.0;
    for (int k = 0; k < 1000; k++)
    {
        before = tick(triangle(k));
    }
    for (int k = 1000; k < 1900; k++)
    {
        // To and fro while b still falls.
        const double u = step(&x, k == 1010 || k == 1020 ? &x.params : &other.params, triangle(k), 0.0);
        TEST_ASSERT_DOUBLE_WITHIN(8e-4,
                                  before,
                                  u); // 0.1 mN of r, and the way to less friction in a quarter of a second
        before = u;
    }
    for (int k = 1900; k < 9900; k++)
    {
        before = step(&x, &other.params, triangle(k), 0.0);
    }
    TEST_ASSERT_DOUBLE_WITHIN(2e-6, triangle(9899) + 0.1 * TAU + 0.2 * (L0 + L1 * triangle(9899)), before);
}

static void test_a_bad_first_reference_waits_and_a_later_one_is_the_last(void)
{
    for (int k = 0; k < 10; k++) // and a change of params before the first tick
    {
        TEST_ASSERT_TRUE(step(&x, k < 5 ? &x.params : &x.fed, 3.0, 0.0) == 0.0);
    }
    reset(&x);
    for (int k = 0; k < 10; k++)
    {
        TEST_ASSERT_TRUE(step(&x, k < 5 ? &x.fed : &x.params, 3.0, 0.0) == 0.0);
    }
    for (int k = 0; k <= 1500; k++)
    {
        (void)tick(triangle(k));
    }
    const double u = tick(triangle(1500));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, u, step(&x, &x.params, 3.0, 0.0));
#if !TRIBO_IS_Q31
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, u, step(&x, &x.params, (double)NAN, 0.0));
#endif
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, u, tick(triangle(1500)));
}

/// The motion of an earlier run ended before the other method began.
static void test_entered_from_another_method_it_knows_no_motion(void)
{
    TRIBO(force_loop, functions_t) functions;
    TRIBO(sensorless, method)(&functions);
    x.memory.motion.was_known = 1;
    functions.enter(&x.memory, 0, false);
    TEST_ASSERT_EQUAL_UINT8(1, x.memory.motion.was_known);
    functions.enter(&x.memory, 0, true);
    TEST_ASSERT_EQUAL_UINT8(0, x.memory.motion.was_known);
}

/// What is to be added for u to go on, until a good reference comes.
static void test_entered_beside_a_bad_reference_it_adds_what_was_added(void)
{
    const double unit = TRIBO_EITHER(1.0, FULL_SCALE_N / 2147483648.0);
    TRIBO(force_loop, functions_t) functions;
    TRIBO(sensorless, method)(&functions);
    functions.enter(&x.memory, to_force(0.0625), true);
    for (int k = 0; k < 3; k++)
    {
        TEST_ASSERT_TRUE(functions.error(&x.params, &x.memory, to_force(3.0), 0, TRIBO_ALL) == 0);
        TEST_ASSERT_TRUE((double)functions.term(&x.params, &x.memory, 0) * unit == 0.0625);
        TEST_ASSERT_TRUE(x.memory.state.tick.TRIBO_N(friction) == 0);
    }
}

/// The hand-over builds on the controller's state, as with a sensor.
static void test_u_goes_on_where_a_sensor_fails_with_a_bad_reading(void)
{
    static blind_t other;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&other));
    double F = 0.3;
    for (int k = 0; k < 1500; k++)
    {
        const double u = step(&x, &x.fed, triangle(k), F);
        TEST_ASSERT_TRUE(u == step(&other, &other.fed, triangle(k), F));
        F += 0.05 * (u - F);
    }
    const double going = step(&other, &other.fed, triangle(1500), 3.0);
    double       u     = step(&x, &x.params, triangle(1500), 3.0);
    TEST_ASSERT_DOUBLE_WITHIN(3e-4, going, u);
    for (int k = 1501; k < 1520; k++)
    {
        const double before = u;
        u                   = step(&x, &x.params, triangle(k), 3.0);
        TEST_ASSERT_DOUBLE_WITHIN(0.062, before, u); // a tenth of friction, and its lead
    }
}

static void test_a_guard_and_a_log_see_the_friction_of_the_last_tick(void)
{
    const double unit = TRIBO_EITHER(1.0, FULL_SCALE_N / 2147483648.0);
    TEST_ASSERT_TRUE(x.memory.state.tick.TRIBO_N(friction) == 0);
    for (int k = 0; k < 1500; k++)
    {
        (void)tick(triangle(k));
    }
    TEST_ASSERT_TRUE((double)x.memory.state.tick.TRIBO_N(friction) * unit == friction_now());
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.9 * (L0 + L1 * 0.45), friction_now());
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, triangle(1499), from_force(x.signals.compensator.TRIBO_N(force)));
}

static void test_a_corrupt_mode_starts_again(void)
{
    for (int k = 0; k < 1500; k++)
    {
        (void)tick(triangle(k));
    }
    x.memory.state.mode = 77;
    double u            = 0.0;
    for (int k = 1500; k < 9900; k++)
    {
        u = tick(triangle(k));
        TEST_ASSERT_TRUE(fabs(u) < 1.0);
    }
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, triangle(9899) + 0.1 * TAU + 0.9 * (L0 + L1 * triangle(9899)), u);
}

#if TRIBO_IS_Q31
/// With a sanitizer it would say so.
static void test_no_sum_overflows_at_the_ends_of_the_scale_and_in_a_corrupt_state(void)
{
    tribo_force_loop_q31_functions_t functions;
    tribo_sensorless_q31_method(&functions);
    static const int32_t end[] = {INT32_MIN, INT32_MAX, -INT32_MAX, 0, 1, -1, 1 << 30, -(1 << 30)};
    random_t             r     = {.state = 31};

    config.compensator.friction.positive.slope = 2.0f; // L beyond full scale
    config.compensator.friction.negative.slope = 0.9f;
    config.compensator.friction.gravity_n      = 3.9f;
    config.input_max_n                         = 4.0f;
    config.usual_force_n                       = 1.0f;
    config.controller.u_min_n                  = -4.0f;
    config.controller.u_max_n                  = 4.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&x));
    memset(&x.memory.motion, 0, sizeof x.memory.motion);
    tribo_force_estimate_q31_t of = {.runs = 0};
    for (int k = 0; k < 200000; k++)
    {
        tribo_feedforward_q31_state_t *state = &x.memory.state;
        int32_t *const                 corrupt[] =
            {&state->sigma, &state->b, &state->tick.term, &state->rate, &of.low, &of.force, &of.high, &of.lagged};
        if (k % 5 == 0)
        {
            *corrupt[random_bits(&r) % 8u] = end[random_bits(&r) % 8u];
        }
        if (k % 3 == 0)
        {
            tribo_sensorless_q31_motion(&x.memory, end[random_bits(&r) % 8u], end[random_bits(&r) % 8u]);
        }
        tribo_force_loop_q31_signals_t seen = {.controller = {.limited = false}};
        const int32_t                  v    = end[random_bits(&r) % 8u];
        const int32_t                  in   = end[random_bits(&r) % 8u];
        (void)functions.error(&x.params, &x.memory, in, end[random_bits(&r) % 8u], UINT32_MAX);
        (void)functions.term(&x.params, &x.memory, v);
        functions.after(&x.params, &x.memory, v, in, &seen);
        tribo_force_estimate_q31_step(&x.params, &x.own, &of, random_bits(&r) % 2u != 0u ? UINT32_MAX : 0u, in);
        TEST_ASSERT_TRUE(x.memory.state.f <= 1 << 29 && x.memory.state.f >= -(1 << 29));
        TEST_ASSERT_TRUE(x.memory.state.b <= 1 << 29 && x.memory.state.b >= -(1 << 29));
    }
}
#endif

#if !TRIBO_IS_Q31
static void test_a_state_that_is_no_number_is_forgotten_and_counted_and_u_goes_on(void)
{
    float *const numbers[] = {&x.memory.state.reached,
                              &x.memory.state.rate,
                              &x.memory.state.behind[0],
                              &x.memory.state.b};
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
    {
        double u = 0.0;
        reset(&x);
        for (int k = 0; k < 1500; k++)
        {
            u = tick(triangle(k));
        }
        *numbers[i] = NAN;
        if (i == 3)
        {
            x.memory.state.tick.term_n = NAN;
            TEST_ASSERT_TRUE(tick(triangle(1500)) == 0.0);
            continue;
        }
        TEST_ASSERT_DOUBLE_WITHIN(2e-4, u, tick(triangle(1500)));
        TEST_ASSERT_DOUBLE_WITHIN(1e-2, u, tick(triangle(1501)));
        TEST_ASSERT_EQUAL_UINT32(1, x.memory.state.forgotten);
        for (int k = 1502; k < 9900; k++)
        {
            u = tick(triangle(k));
        }
        TEST_ASSERT_DOUBLE_WITHIN(CLOSE, triangle(9899) + 0.1 * TAU + 0.9 * (L0 + L1 * triangle(9899)), u);
    }
}
#endif

static void test_set_up_refuses_a_belief_out_of_range(void)
{
    const float bad[] = {-0.01f, 1.01f, NAN};
    for (size_t i = 0; i < 3; i++)
    {
        sensorless.belief = bad[i];
        TEST_ASSERT_EQUAL_INT(TRIBO_ERR_BELIEF, init(&x));
    }
    const float good[] = {0.0f, 1.0f};
    for (size_t i = 0; i < 2; i++)
    {
        sensorless.belief = good[i];
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&x));
        double u = 0.0;
        for (int k = 0; k <= 1500; k++)
        {
            u = tick(triangle(k));
        }
        TEST_ASSERT_DOUBLE_WITHIN(CLOSE, triangle(1500) + 0.1 * TAU + (double)good[i] * (L0 + L1 * triangle(1500)), u);
    }
    method.jump_lead = 2.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_JUMP_LEAD, init(&x));
    config.method = TRIBO(sensorless, use)(&x.own, &method, NULL);
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_init_loop(&x.params, x.table[0], &config, (float)FULL_SCALE_N));
}

// --- the force, from u alone ---------------------------------------------------------------------------------------

typedef struct
{
    double F, low, high;
} estimated_t;

static TRIBO(force_estimate, t) estimate;

static estimated_t estimated(double u, double tolerance)
{
    TRIBO(force_estimate, step)(&x.params,
                                &x.own,
                                &estimate,
                                TRIBO_EITHER((float)tolerance, (uint32_t)(tolerance * 4294967295.0)),
                                to_force(u));
    const double unit = TRIBO_EITHER(1.0, FULL_SCALE_N / 536870912.0);
    return (estimated_t){.F    = (double)estimate.force * unit,
                         .low  = (double)estimate.low * unit,
                         .high = (double)estimate.high * unit};
}

static void test_the_force_is_that_of_an_arm_that_sticks_within_its_breakaway(void)
{
    estimated_t at = {.F = 0.0};
    memset(&estimate, 0, sizeof estimate);
    for (int k = 0; k < 3000; k++)
    {
        at = estimated(0.5, 0.2); // nothing has moved: F is anywhere in the band
    }
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, (0.5 - 1.2 * L0) / (1.0 + 1.2 * L1), at.low);
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, (0.5 + 1.2 * L0) / (1.0 - 1.2 * L1), at.high);
    TEST_ASSERT_TRUE(at.F == 0.5);
    for (int k = 0; k < 3000; k++)
    {
        at = estimated(fmin(1.5, 0.5 + 1e-3 * k), 0.2);
    }
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, (1.5 - 1.2 * L0) / (1.0 + 1.2 * L1), at.low); // it slides
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, (1.5 - 0.8 * L0) / (1.0 + 0.8 * L1), at.high);
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, (1.5 - L0) / (1.0 + L1), at.F);
    const estimated_t before = at;
    for (int k = 0; k < 300; k++)
    {
        at = estimated(1.2, 0.2); // it sticks
    }
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, before.F, at.F);
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, before.low, at.low);
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, before.high, at.high);
    for (int k = 0; k < 3000; k++)
    {
        at = estimated(0.2, 0.2); // it slides back
    }
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, (0.2 + 0.8 * L0) / (1.0 - 0.8 * L1), at.low);
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, (0.2 + 1.2 * L0) / (1.0 - 1.2 * L1), at.high);
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, (0.2 + L0) / (1.0 - L1), at.F);
}

/// Four fixed-point steps a tick, each of which leaves L1 times the error.
static void test_an_estimate_that_slides_takes_four_steps_a_tick(void)
{
    memset(&estimate, 0, sizeof estimate);
    (void)estimated(0.5, 0.0);
    double u = 0.5;
    double F = estimated(0.5, 0.0).F;
    for (int k = 0; k < 100; k++)
    {
        const double before = F;
        u += (H / (TAU + H)) * (1.9 - u);
        for (int i = 0; i < 4; i++)
        {
            F = fmax(before, u - (L0 + L1 * F));
        }
        TEST_ASSERT_DOUBLE_WITHIN(CLOSE, F, estimated(1.9, 0.0).F);
    }
}

/// The first tick knows nothing but u, and has its band at once.
static void test_an_estimate_starts_at_u(void)
{
    memset(&estimate, 0, sizeof estimate);
    const estimated_t at = estimated(0.5, 0.2);
    TEST_ASSERT_TRUE(at.F == 0.5);
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, (0.5 - 1.2 * L0) / (1.0 + 1.2 * L1), at.low);
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, (0.5 + 1.2 * L0) / (1.0 - 1.2 * L1), at.high);
}

static void test_each_direction_of_the_estimate_has_its_breakaway_and_gravity_moves_both(void)
{
    config.compensator.friction.negative.offset_n = 0.05f;
    config.compensator.friction.negative.slope    = 0.2f;
    config.compensator.friction.gravity_n         = 0.02f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&x));
    memset(&estimate, 0, sizeof estimate);
    estimated_t at = {.F = 0.0};
    for (int k = 0; k < 3000; k++)
    {
        at = estimated(fmin(1.5, 1e-3 * k), 0.2);
    }
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, (1.52 - L0) / (1.0 + L1), at.F);
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, (1.52 - 1.2 * L0) / (1.0 + 1.2 * L1), at.low);
    for (int k = 0; k < 3000; k++)
    {
        at = estimated(0.2, 0.2);
    }
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, (0.22 + 0.05) / (1.0 - 0.2), at.F);
    TEST_ASSERT_DOUBLE_WITHIN(CLOSE, (0.22 + 1.2 * 0.05) / (1.0 - 1.2 * 0.2), at.high);
}

/// The estimate is that of one that never ran.
static void test_a_restart_leaves_nothing_behind(void)
{
    static blind_t other;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&other));
    for (int k = 0; k < 2500; k++)
    {
        (void)tick(1.5 + triangle(k));
    }
    x.memory.state.b       = TRIBO_EITHER(0.1f, 1 << 25);
    x.memory.state.limited = 1;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, TRIBO(force_loop, start)(&x.state, &x.params, true));
    for (int k = 0; k < 3000; k++)
    {
        TEST_ASSERT_TRUE(tick(triangle(k)) == step(&other, &other.params, triangle(k), 0.0));
        TEST_ASSERT_TRUE(x.signals.compensator.TRIBO_N(force) == other.signals.compensator.TRIBO_N(force));
    }
}

static void test_a_force_follows_u_with_the_lag_of_actuator_and_arm(void)
{
    memset(&estimate, 0, sizeof estimate);
    (void)estimated(0.0, 0.0);
    int k = 0;
    while (estimated(1.0, 0.0).F < (1.0 - exp(-1.0)) * (1.0 - L0) / (1.0 + L1) && k < 100)
    {
        k++;
    }
    TEST_ASSERT_INT_WITHIN(2, 12, k); // tau
}

static void test_an_estimate_takes_nothing_that_is_not_credible_and_heals(void)
{
    memset(&estimate, 0, sizeof estimate);
    for (int k = 0; k < 3000; k++)
    {
        (void)estimated(1e-3 * fmin(k, 800), 0.1);
    }
    const TRIBO(force_estimate, t) before = estimate;
#if !TRIBO_IS_Q31
    (void)estimated((double)NAN, 0.1);
    (void)estimated(0.8, (double)NAN);
    (void)estimated(0.8, 1.05);
#endif
    (void)estimated(2.5, 0.1);
    TEST_ASSERT_EQUAL_MEMORY(&before, &estimate, sizeof before);
    for (int i = 0; i < 4; i++)
    {
        tribo_force_t *const numbers[] = {&estimate.lagged, &estimate.force, &estimate.low, &estimate.high};
        *numbers[i]                    = TRIBO_EITHER(NAN, INT32_MIN);
        estimated_t at                 = {.F = 0.0};
        for (int k = 0; k < 3000; k++)
        {
            at = estimated(0.8 + 1e-3 * fmax(0.0, fmin(k - 500, 800)), 0.1);
        }
        TEST_ASSERT_DOUBLE_WITHIN(CLOSE, (1.6 - 1.1 * L0) / (1.0 + 1.1 * L1), at.low);
        TEST_ASSERT_DOUBLE_WITHIN(CLOSE, (1.6 - 0.9 * L0) / (1.0 + 0.9 * L1), at.high);
        TEST_ASSERT_DOUBLE_WITHIN(CLOSE, (1.6 - L0) / (1.0 + L1), at.F);
    }
}

#include "runners/test_sensorless.inc" // main
