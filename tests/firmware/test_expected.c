// What u leads to without friction, against the same chain of equations integrated in double in small steps.

#include "app/expected.h"
#include "app/loop.h"
#include "runs.h"
#include "unity.h"

#include <math.h>

#define FULL_N 4.0f
#define STEPS  RUNS(1000, 100) // of the rig in a tick
#define H_S    (1e-3 / STEPS)

static loop_setup_t     loop;
static drive_config_t   config;
static expected_t       expected;
static expected_state_t state;

/// The paper's rig in double.
static struct
{
    double drive_n, angle_deg, speed_deg_per_s, y_n;
} rig;

static double gravity_n;

void setUp(void)
{
    tribo_force_loop_f32_config_t paper  = tribo_force_loop_f32_paper();
    paper.compensator.friction.gravity_n = (float)gravity_n;
    config                               = drive_config_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_setup(&loop, &paper, FULL_N));
    expected_init(&expected, &config, &loop.params);
    expected_reset(&state);
    rig.drive_n = rig.angle_deg = rig.speed_deg_per_s = rig.y_n = 0.0;
}

static void step_rig(double u_n)
{
    for (int i = 0; i < STEPS; i++)
    {
        const double force_n = 3.84 * rig.angle_deg;
        rig.drive_n += H_S * 200.0 * (u_n - rig.drive_n);
        rig.speed_deg_per_s += H_S * (rig.drive_n + gravity_n - force_n - 0.0288 * rig.speed_deg_per_s) / 1.2e-4;
        rig.angle_deg += H_S * rig.speed_deg_per_s;
        rig.y_n += H_S * 55.0 * (force_n - rig.y_n);
    }
}

static loop_force_t force(double force_n)
{
    return tribo_force_of_n(force_n, (double)FULL_N);
}

/// u steps between 0 and `high_n`: the largest difference of y within a second, and the one at its end.
static void play(double high_n, double *largest_n, double *last_n)
{
    *largest_n = 0.0;
    for (int k = 0; k < 1000; k++)
    {
        const double u_n = k % 500 < 200 ? 0.0 : high_n;
        expected_step(&expected, &state, force(u_n));
        step_rig(u_n);
        *last_n    = fabs(tribo_force_n(state.y, (double)FULL_N) - rig.y_n);
        *largest_n = fmax(*largest_n, *last_n);
    }
}

/// Its poles see the input at the end of a tick, not at its beginning: half a tick for each of two, of 30 ms that the chain takes.
static void test_it_is_what_the_rig_without_friction_shows(void)
{
    for (double high_n = -1.5; high_n <= 1.5; high_n += 0.5)
    {
        double largest_n, last_n;
        setUp();
        play(high_n, &largest_n, &last_n);
        TEST_ASSERT_DOUBLE_WITHIN(0.04 * fabs(high_n) + 1e-6, 0.0, largest_n);
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.0, last_n);
    }
}

static void test_gravity_is_in_it(void)
{
    for (gravity_n = -0.3; gravity_n <= 0.3; gravity_n += 0.1)
    {
        double largest_n, last_n;
        setUp();
        play(0.5, &largest_n, &last_n);
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.5 + gravity_n, tribo_force_n(state.y, (double)FULL_N));
    }
    gravity_n = 0.0;
}

/// A pole far beyond the sample rate passes its input on within a tick, a slow one hardly moves.
static void test_its_poles_are_those_of_the_config(void)
{
    config.actuator_pole_rad_per_s = 1e6f;
    expected_init(&expected, &config, &loop.params);
    expected_step(&expected, &state, force(1.0));
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, 1.0, tribo_force_n(state.drive, (double)FULL_N));
    setUp();
    config.actuator_pole_rad_per_s = 1.0f;
    config.sensor_pole_rad_per_s   = 10.0f;
    expected_init(&expected, &config, &loop.params);
    for (int k = 0; k < 1000; k++)
    {
        expected_step(&expected, &state, force(1.0));
    }
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, 1.0 - exp(-1.0), tribo_force_n(state.drive, (double)FULL_N));
    TEST_ASSERT_DOUBLE_WITHIN(5e-3,
                              1.0 - exp(-1.0) - (exp(-1.0) - exp(-10.0)) / 9.0,
                              tribo_force_n(state.y, (double)FULL_N));
}

/// At the ends of the arithmetic nothing wraps.
static void test_the_largest_commands_saturate(void)
{
    const loop_force_t most = TRIBO_EITHER(1e6f, INT32_MAX);
    for (int k = 0; k < 2000; k++)
    {
        expected_step(&expected, &state, k < 1000 ? most : -most);
        TEST_ASSERT_TRUE(k > 1000 || state.y >= 0);
        TEST_ASSERT_TRUE(k < 1200 || state.y <= 0);
    }
}

#include "runners/test_expected.inc" // main
