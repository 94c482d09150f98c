// The current controller on a winding of the test's own: R and L integrated in double, the voltage half a sample late and held for
// one, as a centre-aligned timer with preload applies it.

#include "bridge/current.h"

#include "unity.h"

#include <math.h>

#define T_S     50e-6
#define STEPS   50   // of the winding in half a sample
#define SETTLES 6    // samples, 0.3 ms, in which a step must have settled ...
#define SETTLED 0.05 // ... to within this part of it
#define BUS_V   24.0f

typedef struct
{
    double r_ohm, l_h, emf_v, current_a, v, next_v;
} winding_t;

static current_params_t params;
static current_state_t  state;
static winding_t        winding;
static float            most_v;

static current_config_t config_of(double r_ohm, double l_h)
{
    return (current_config_t){.resistance_ohm = (float)r_ohm,
                              .inductance_h   = (float)l_h,
                              .bandwidth_hz   = 1250.0f,
                              .sample_time_s  = (float)T_S,
                              .limit_a        = 4.0f};
}

static void connect(double r_ohm, double l_h)
{
    const current_config_t config = config_of(r_ohm, l_h);
    TEST_ASSERT_TRUE(current_init(&params, &config));
    current_reset(&state);
    winding = (winding_t){.r_ohm = r_ohm, .l_h = l_h};
    most_v  = BUS_V;
}

void setUp(void)
{
    connect(2.0, 1e-3);
}

static void flow_for_half_a_sample(void)
{
    const double h_s = T_S / 2.0 / STEPS;
    for (int i = 0; i < STEPS; i++)
    {
        const double slope = (winding.v - winding.emf_v - winding.r_ohm * winding.current_a) / winding.l_h;
        winding.current_a += h_s * slope;
    }
}

/// A sample at the middle of a period, whose voltage acts from the next period on.
static double run_sample(float reference_a)
{
    const double seen_a = winding.current_a;
    winding.next_v      = (double)current_step(&params, &state, reference_a, (float)seen_a, most_v);
    TEST_ASSERT_TRUE(fabs(winding.next_v) <= (double)most_v);
    flow_for_half_a_sample();
    winding.v = winding.next_v;
    flow_for_half_a_sample();
    return winding.current_a;
}

/// Samples after which the current stays within SETTLED of a step, and how far it overshoots, as a part of the step.
static int settling(float from_a, float to_a, double *overshoot)
{
    const double step_a = (double)to_a - (double)from_a;
    int          last   = 0;
    *overshoot          = 0.0;
    for (int n = 1; n <= 200; n++)
    {
        const double done = (run_sample(to_a) - (double)from_a) / step_a;
        *overshoot        = fmax(*overshoot, done - 1.0);
        last              = fabs(done - 1.0) > SETTLED ? n + 1 : last;
    }
    return last;
}

static void test_a_step_settles_within_300_us_whatever_the_winding(void)
{
    const double r_ohm[] = {0.2, 1.0, 4.0}; // poles from a hundredth of a sample to two
    const double l_h[]   = {0.1e-3, 0.3e-3, 1e-3};
    for (int i = 0; i < 3; i++)
    {
        for (int k = 0; k < 3; k++)
        {
            double overshoot;
            connect(r_ohm[i], l_h[k]);
            const int up = settling(0.0f, 1.5f, &overshoot);
            TEST_ASSERT_TRUE_MESSAGE(up <= SETTLES, "up");
            TEST_ASSERT_TRUE(overshoot <= 0.10);
            const int down = settling(1.5f, -1.5f, &overshoot);
            TEST_ASSERT_TRUE_MESSAGE(down <= SETTLES, "down");
            TEST_ASSERT_TRUE(overshoot <= 0.10);
        }
    }
}

static void test_the_windings_pole_is_cancelled(void)
{
    double first[20];
    for (int i = 0; i < 20; i++)
    {
        first[i] = run_sample(0.1f);
    }
    connect(0.5, 0.25e-3); // the same pole ...
    for (int i = 0; i < 20; i++)
    {
        TEST_ASSERT_TRUE(fabs(run_sample(0.1f) - first[i]) < 1e-6);
    }
    connect(8.0, 0.5e-3); // ... and one that is 8 times as fast, whose samples differ from s
    for (int i = 0; i < 20; i++)
    {
        TEST_ASSERT_TRUE(fabs(run_sample(0.1f) - first[i]) < 0.1 * 0.1);
    }
}

static void test_a_winding_of_half_or_twice_the_configured_value_stays_stable(void)
{
    const double factors[] = {0.5, 2.0};
    for (int i = 0; i < 2; i++)
    {
        connect(2.0, 1e-3);
        winding.l_h *= factors[i];
        winding.r_ohm *= factors[1 - i];
        for (int n = 0; n < 400; n++)
        {
            (void)run_sample(1.0f);
        }
        TEST_ASSERT_TRUE(fabs(winding.current_a - 1.0) < 0.01);
    }
}

static void test_a_back_emf_is_made_up_for(void)
{
    for (int n = 0; n < 100; n++)
    {
        (void)run_sample(1.0f);
    }
    winding.emf_v = 6.0;
    double worst  = 0.0;
    for (int n = 0; n < 100; n++)
    {
        worst = fmax(worst, fabs(run_sample(1.0f) - 1.0));
    }
    TEST_ASSERT_TRUE(worst > 0.1);                          // it is felt ...
    TEST_ASSERT_TRUE(fabs(winding.current_a - 1.0) < 0.01); // ... and gone
}

static void test_the_reference_is_limited(void)
{
    for (int n = 0; n < 400; n++)
    {
        TEST_ASSERT_TRUE(run_sample(n < 200 ? 100.0f : INFINITY) <= 4.0 * 1.1);
    }
    TEST_ASSERT_TRUE(fabs(winding.current_a - 4.0) < 0.01);
    for (int n = 0; n < 400; n++)
    {
        TEST_ASSERT_TRUE(run_sample(-100.0f) >= -4.0 * 1.1);
    }
    TEST_ASSERT_TRUE(fabs(winding.current_a + 4.0) < 0.01);
}

static void test_a_reference_that_is_no_number_is_0(void)
{
    for (int n = 0; n < 100; n++)
    {
        (void)run_sample(1.0f);
    }
    for (int n = 0; n < 100; n++)
    {
        (void)run_sample(NAN);
    }
    TEST_ASSERT_TRUE(fabs(winding.current_a) < 0.01);
}

static void test_the_integral_does_not_wind_up_at_the_voltage_limit(void)
{
    most_v = 3.0f; // for 1.5 A of 4
    for (int n = 0; n < 20000; n++)
    {
        (void)run_sample(4.0f);
    }
    TEST_ASSERT_TRUE(state.limited);
    TEST_ASSERT_TRUE(fabs(winding.current_a - 1.5) < 0.01);
    double overshoot;
    TEST_ASSERT_TRUE(settling(1.5f, 0.5f, &overshoot) <= SETTLES);
    TEST_ASSERT_TRUE(overshoot <= 0.10);
    TEST_ASSERT_FALSE(state.limited);
}

static void test_a_bus_that_is_gone_leaves_nothing_in_the_integral(void)
{
    for (int n = 0; n < 100; n++)
    {
        (void)run_sample(2.0f);
    }
    most_v = 0.0f;
    for (int n = 0; n < 2000; n++)
    {
        (void)run_sample(2.0f);
    }
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, 0.0f, state.integral_v);
    most_v = BUS_V;
    double overshoot;
    TEST_ASSERT_TRUE(settling(0.0f, 2.0f, &overshoot) <= SETTLES);
}

static void test_what_is_not_positive_or_too_fast_is_refused(void)
{
    const float wrong[] = {0.0f, -1.0f, NAN, INFINITY};
    for (int i = 0; i < 4; i++)
    {
        current_config_t configs[5];
        for (int k = 0; k < 5; k++)
        {
            configs[k] = config_of(2.0, 1e-3);
        }
        configs[0].resistance_ohm = wrong[i];
        configs[1].inductance_h   = wrong[i];
        configs[2].bandwidth_hz   = wrong[i];
        configs[3].sample_time_s  = wrong[i];
        configs[4].limit_a        = wrong[i];
        for (int k = 0; k < 5; k++)
        {
            const current_params_t before = params;
            TEST_ASSERT_FALSE(current_init(&params, &configs[k]));
            TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
        }
    }
    current_config_t resistor = config_of(2.0, 0.49e-4);
    TEST_ASSERT_FALSE(current_init(&params, &resistor));
    current_config_t fast = config_of(2.0, 1e-3);
    fast.bandwidth_hz     = current_bandwidth_max_hz((float)T_S);
    TEST_ASSERT_TRUE(current_init(&params, &fast));
    fast.bandwidth_hz *= 1.001f;
    TEST_ASSERT_FALSE(current_init(&params, &fast));
}

#include "runners/test_current.inc" // main
