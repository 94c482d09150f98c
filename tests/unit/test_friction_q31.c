#include "controller/biquad_f32.h"
#include "controller/biquad_q31.h"
#include "friction/arm_q31.h"
#include "friction/law_f32.h"
#include "friction/law_q31.h"
#include "tribo/force_loop_q31.h"
#include "tribo/friction_q31.h"

#include "plain_relays.h"
#include "random.h"
#include "runs.h"
#include "unity.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#define H          1.0e-3f
#define FULL_SCALE 2.0f

static tribo_friction_f32_config_t  config;
static tribo_friction_q31_params_t  params;
static tribo_friction_q31_state_t   state;
static tribo_friction_q31_signals_t seen;

static bool shows(const tribo_friction_q31_signals_t *signals, uint8_t relay)
{
    return (signals->relays & relay) != 0u;
}
static tribo_breakaway_point_q31_t points[TRIBO_BREAKAWAY_POINTS_MAX];

static void init(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_q31_init(&params, points, &config, H, FULL_SCALE));
    tribo_friction_q31_reset(&state);
}

void setUp(void)
{
    config = tribo_force_loop_f32_paper().compensator.friction;
    init();
}

static int32_t q31(double force_n)
{
    return (int32_t)round(force_n / (double)FULL_SCALE * 2147483648.0);
}

static double newton(int32_t x)
{
    return x / 2147483648.0 * (double)FULL_SCALE;
}

static double step(double u, double F)
{
    return newton(tribo_friction_q31_step(&params, &state, q31(u), q31(F), &seen));
}

// --- the equations -----------------------------------------------------------------------------------------------

/// f of k L tanh(n/(k L)) with L = 1 N, in N, for a constant k.
static double curve(double n)
{
    tribo_friction_q31_reset(&state);
    state.relay.latch.held = TRIBO_RELAY_Q2;
    return step(n, 0.0);
}

static void test_friction_curve_is_as_close_as_its_header_says(void)
{
    const float ks[]  = {1.01f, 1.1f, 2.0f, 6.0f, 20.0f, 1000.0f, 1.01f}; // the last one far beyond its breakaway
    double      worst = 0.0;
    for (size_t i = 0; i < sizeof ks / sizeof ks[0]; i++)
    {
        config.k_min             = ks[i];
        config.k_max             = ks[i];
        config.positive.slope    = 0.0f;
        config.positive.offset_n = i < 6u ? 1.0f : 0.4f;
        init();
        const double L    = (double)config.positive.offset_n;
        const double k    = (double)ks[i];
        double       here = 0.0;
        for (int j = 1; j < 40000; j += RUNS(1, 10))
        {
            const double n     = 1.9999 * j / 40000.0;
            const double f     = curve(n);
            const double exact = fmin(L, k * L * tanh(newton(seen.n) / (k * L)));
            TEST_ASSERT_TRUE(shows(&seen, TRIBO_RELAY_Q));
            TEST_ASSERT_TRUE(f <= newton(seen.n));
            here = fmax(here, (fabs(f - exact) - 4.0 * newton(1)) / exact); // beyond the last bits
        }
        printf("k = %g: k L tanh(n/(k L)) within %.2e of itself, and 4 LSB\n", k, here);
        worst = fmax(worst, here);
    }
    TEST_ASSERT_DOUBLE_WITHIN(9e-7, 0.0, worst);
}

// A small breakaway beside what it may grow to, at the k_min of a wide range: the fewest bits.
static void test_friction_curve_of_a_small_breakaway_is_as_close_as_its_header_says(void)
{
    const float ratios[] = {2.0f, 20.0f, 900.0f};
    for (size_t i = 0; i < sizeof ratios / sizeof ratios[0]; i++)
    {
        config.k_min             = 1.1f;
        config.k_max             = 1.1f * ratios[i];
        config.v0_n_per_s        = 1.0e-4f; // far below the rate of any step here
        config.m                 = 10.0f;
        config.positive.offset_n = 1.0e-5f;
        config.positive.slope    = 0.5f;
        init();
        const double k     = (double)config.k_min;
        const double L     = (double)config.positive.offset_n;
        double       worst = 0.0;
        for (int j = 50; j < 4000; j++)
        {
            const double f     = curve(3e-5 * j / 4000.0);
            const double exact = fmin(L, k * L * tanh(newton(seen.n) / (k * L)));
            TEST_ASSERT_TRUE(shows(&seen, TRIBO_RELAY_Q));
            worst = fmax(worst, fabs(f - exact) / newton(1));
        }
        printf("k from 1.1 to %g, L = 1e-5 N: within %.1f LSB\n", (double)config.k_max, worst);
        TEST_ASSERT_TRUE(worst <= (ratios[i] < 900.0f ? 4.0 : 23.0));
    }
}

// k(v) from f at n = 0.9 N, with dk/df of the curve.
static void test_friction_k_of_v_is_as_close_as_its_header_says(void)
{
    config.k_min             = 2.0f;
    config.k_max             = 20.0f;
    config.m                 = 10.0f;
    config.v0_n_per_s        = 1.0f;
    config.positive.slope    = 0.0f;
    config.positive.offset_n = 1.0f;
    init();
    double worst = 0.0;
    for (int i = 0; i <= 20000; i += RUNS(1, 10))
    {
        const double x = -9.9 + 0.00095 * i; // m (v/v0 - 1)
        tribo_friction_q31_reset(&state);
        state.relay.latch.held = TRIBO_RELAY_Q2;
        state.n                = q31(0.9);
        const double n         = 0.9 + 1e-3 * (x / 10.0 + 1.0);
        const double f         = step(n, 0.0);
        const double exact_n   = newton(seen.n);
        const double v         = newton(seen.rise) * 1e3;
        const double k         = 11.0 - 9.0 * tanh(10.0 * (v - 1.0));
        // One step of Newton's from the exact k: the curve's own error counts as k's.
        const double s     = exact_n / k;
        const double slope = tanh(s) - s / pow(cosh(s), 2.0);
        const double error = (f - fmin(1.0, k * tanh(s))) / slope;
        worst              = fmax(worst, k < 3.0 ? fabs(error) : 0.0); // where the slope shows it
        TEST_ASSERT_DOUBLE_WITHIN(18.0 * 2e-6 * slope + 9e-7, fmin(1.0, k * tanh(s)), f);
    }
    printf("k(v) of 2 to 20: within %.1e, %.1e of its range\n", worst, worst / 18.0);
    TEST_ASSERT_DOUBLE_WITHIN(18.0 * 2e-6, 0.0, worst);
}

static void test_friction_takes_k_of_v_to_the_ends_of_its_params(void)
{
    config.k_min      = 1.01f;
    config.k_max      = 1000.0f;
    config.m          = 100.0f;
    config.v0_n_per_s = 1.0e-4f;
    init();
    for (int sign = -1; sign <= 1; sign += 2)
    {
        for (int i = 0; i < 2000; i++)
        {
            tribo_friction_q31_reset(&state);
            state.relay.latch.held = TRIBO_RELAY_Q2 | TRIBO_RELAY_Q1;
            const double f         = step(sign * 0.001 * i, 0.0);
            TEST_ASSERT_TRUE(sign * f >= 0.0 && fabs(f) <= newton(seen.L) && fabs(f) <= fabs(newton(seen.n)));
        }
    }
}

static void test_friction_of_symmetric_params_is_a_mirror_image_to_the_last_bit(void)
{
    tribo_friction_q31_state_t   mirror = state;
    tribo_friction_q31_signals_t image;
    uint32_t                     word = 1;
    int32_t                      u    = 0;
    int                          q    = 0;
    for (int k = 0; k < 50000; k++)
    {
        word            = word * 1664525u + 1013904223u;
        const int32_t F = k / 100 % 2 == 0 ? 400000000 : -300000000;
        u               = k % 20 == 0 ? F + (int32_t)word / 16 : u + (int32_t)(word >> 20) - 2048;
        const int32_t f = tribo_friction_q31_step(&params, &state, u, F, &seen);
        TEST_ASSERT_EQUAL_INT32(-f, tribo_friction_q31_step(&params, &mirror, -u, -F, &image));
        TEST_ASSERT_TRUE(shows(&image, TRIBO_RELAY_Q) == shows(&seen, TRIBO_RELAY_Q) &&
                         shows(&image, TRIBO_RELAY_Q1) == shows(&seen, TRIBO_RELAY_Q2) &&
                         shows(&image, TRIBO_RELAY_Q2) == shows(&seen, TRIBO_RELAY_Q1) && image.L == seen.L);
        q += shows(&seen, TRIBO_RELAY_Q);
    }
    TEST_ASSERT_TRUE(q > 1000);
}

// --- rounding of params ------------------------------------------------------------------------------------------

// To nearest, halves up; a float of 2^23 units or more has no half.
static void test_friction_init_rounds_levels_to_the_nearest_unit(void)
{
    random_t r = {14};
    for (int i = 0; i < 6000; i += RUNS(1, 20))
    {
        const double units = i < 2000
                                 ? random_between(&r, 4400.0, 7.4e6)
                                 : (i < 4000 ? random_between(&r, 7.4e6, 9.3e6) : random_between(&r, 9.3e6, 4.2e9));
        config.set_level   = (float)ldexp(units, -32);
        config.reset_level = config.set_level;
        config.positive    = (tribo_breakaway_f32_t){.offset_n = 1.0f, .slope = (float)ldexp(units, -32)};
        init();
        const uint32_t expected = (uint32_t)floor(ldexp((double)config.set_level, 32) + 0.5);
        TEST_ASSERT_EQUAL_UINT32(expected, params.set_level);
        TEST_ASSERT_EQUAL_UINT32(expected, params.reset_level);
        TEST_ASSERT_EQUAL_UINT32(expected, params.law[0].slope);
    }
    config.set_level = 1.0f;
    init();
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, params.set_level);
}

static void test_friction_init_rounds_forces_to_the_nearest_unit_of_either_sign(void)
{
    random_t r = {15};
    for (int i = 0; i < 6000; i += RUNS(1, 20))
    {
        const double units = i < 2000
                                 ? random_between(&r, 0.1, 7.4e6)
                                 : (i < 4000 ? random_between(&r, 7.4e6, 9.3e6) : random_between(&r, 9.3e6, 2.1e9));
        config.gravity_n   = (float)ldexp(units, -30); // at a full scale of 2 N
        init();
        const int32_t expected = (int32_t)floor(ldexp((double)config.gravity_n, 30) + 0.5);
        TEST_ASSERT_EQUAL_INT32(expected, params.gravity);
        config.gravity_n = -config.gravity_n;
        init();
        TEST_ASSERT_EQUAL_INT32(-expected, params.gravity);
    }
}

// --- what must never happen --------------------------------------------------------------------------------------

static void test_friction_saturates_net_force_and_breakaway_at_full_scale(void)
{
    config.positive.slope = 10.0f;
    config.negative.slope = 10.0f;
    init();
    const int32_t inputs[]    = {INT32_MIN, -INT32_MAX, -1, 0, 1, (1 << 30) + 1, INT32_MAX};
    const int32_t gravities[] = {1 << 30, -(1 << 30), 0};
    uint32_t      counted     = 0;
    for (size_t i = 0; i < 7u * 7u * 3u; i++)
    {
        const int32_t u      = inputs[i % 7u];
        const int32_t force  = inputs[i / 7u % 7u];
        params.gravity       = gravities[i / 49u];
        const int64_t n      = (int64_t)u - force + params.gravity;
        const int32_t f      = tribo_friction_q31_step(&params, &state, u, force, &seen);
        const bool    beyond = n > INT32_MAX || n < -INT32_MAX;
        counted += beyond;
        TEST_ASSERT_EQUAL_INT32(beyond ? (n < 0 ? -INT32_MAX : INT32_MAX) : n, seen.n);
        TEST_ASSERT_EQUAL_UINT32(counted, state.saturated);
        TEST_ASSERT_TRUE((int64_t)f * seen.n >= 0);
        TEST_ASSERT_TRUE(f <= seen.L && f >= -seen.L);
    }
    TEST_ASSERT_TRUE(counted > 12u);
    tribo_friction_q31_reset(&state);
    (void)tribo_friction_q31_step(&params, &state, INT32_MAX, -INT32_MAX, &seen);
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, seen.n);
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, seen.L);
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, seen.f);
    (void)tribo_friction_q31_step(&params, &state, INT32_MIN, INT32_MAX, &seen);
    TEST_ASSERT_EQUAL_INT32(-INT32_MAX, seen.f);
    TEST_ASSERT_EQUAL_INT32(0, seen.rise);
}

// --- the relays against their comparators, one by one --------------------------------------------------------------

// Levels as the header has them, rounded down; met to the bit, and missed by one.
static void check_relays(random_t *r)
{
    plain_relays_t plain = plain_relays_at_rest();
    init();
    int32_t before   = 0;
    int     switches = 0;
    for (int k = 0; k < 20000; k++)
    {
        const int32_t eighth = INT32_C(1) << 28; // of full scale; L+ = 1/4 + |F|, L- = 1/8 + |F|/2, c1 = 3/4, c2 = 1/2
        const int32_t size   = (int32_t)(random_bits(r) % 5u) * (eighth / 2);
        const int32_t F      = random_bits(r) % 2u == 0u ? size : -size;
        const int32_t p      = 2 * eighth + size;
        const int32_t m      = eighth + size / 2;
        const int32_t any[]  = {before, 0, p / 4 * 3, -(m / 4 * 3), p / 2, -(m / 2), -(p / 2), m / 4 * 3};
        const int32_t n      = any[random_bits(r) % 8u] + (int32_t)(random_bits(r) % 3u) - 1;
        const bool    line[] = {n<p / 4 * 3, n> - (m / 4 * 3),
                                n > before && before < -(m / 2),
                                n < before && before > p / 2};
        const bool    q1     = plain.output[0];
        plain_relays_step(&plain, params.pulse_width, line);
        (void)tribo_friction_q31_step(&params, &state, F + n, F, &seen);
        TEST_ASSERT_EQUAL_INT32(n, seen.n);
        TEST_ASSERT_EQUAL_INT32(n < 0 ? m : p, seen.L);
        TEST_ASSERT_EQUAL_INT(plain.output[0], shows(&seen, TRIBO_RELAY_Q1));
        TEST_ASSERT_EQUAL_INT(plain.output[1], shows(&seen, TRIBO_RELAY_Q2));
        TEST_ASSERT_EQUAL_INT(abs(n) > abs(before) &&
                                  (n > 0 ? shows(&seen, TRIBO_RELAY_Q2) : shows(&seen, TRIBO_RELAY_Q1)),
                              shows(&seen, TRIBO_RELAY_Q));
        switches += q1 != plain.output[0];
        before = n;
    }
    TEST_ASSERT_TRUE(switches > 200);
}

static void test_friction_relays_are_those_of_its_comparators(void)
{
    // The law and the same as a table, in newton at a full scale of 2 N.
    static const tribo_breakaway_point_f32_t line[] = {{0.0f, 0.5f, 0.25f},
                                                       {0.125f, 0.625f, 0.3125f},
                                                       {0.25f, 0.75f, 0.375f},
                                                       {0.375f, 0.875f, 0.4375f},
                                                       {0.5f, 1.0f, 0.5f}};
    random_t                                 r      = {1};
    config.positive                                 = (tribo_breakaway_f32_t){.offset_n = 0.5f, .slope = 1.0f};
    config.negative                                 = (tribo_breakaway_f32_t){.offset_n = 0.25f, .slope = 0.5f};
    config.reset_level                              = 0.5f;
    for (uint32_t width = 1; width <= 3u; width++)
    {
        config.pulse_width_s = (float)width * H;
        config.table         = NULL;
        config.table_length  = 0;
        check_relays(&r);
        config.table        = line;
        config.table_length = 5;
        check_relays(&r);
    }
}

static void test_friction_takes_a_rise_of_a_bit_for_a_rise(void)
{
    for (int sign = -1; sign <= 1; sign += 2)
    {
        for (int rise = -1; rise <= 1; rise++)
        {
            tribo_friction_q31_reset(&state);
            state.n                = sign * 1000000;
            state.relay.latch.held = TRIBO_RELAY_Q2 | TRIBO_RELAY_Q1;
            (void)tribo_friction_q31_step(&params, &state, sign * (1000000 + rise), 0, &seen);
            TEST_ASSERT_EQUAL_INT32(rise, seen.rise);
            TEST_ASSERT_EQUAL_INT(rise > 0, shows(&seen, TRIBO_RELAY_Q));
        }
    }
}

// k L tanh(n/(k L)) for n far beyond 2 L: L = 0.1 N of 2 N.
static void test_friction_is_at_its_breakaway_however_far_beyond_n_is(void)
{
    const float ks[] = {1.01f, 1.1f, 2.0f, 20.0f, 1000.0f};
    for (size_t i = 0; i < sizeof ks / sizeof ks[0]; i++)
    {
        config.k_min    = ks[i];
        config.k_max    = ks[i];
        config.positive = (tribo_breakaway_f32_t){.offset_n = 0.1f, .slope = 0.0f};
        init();
        for (int j = 1; j < 4000; j++)
        {
            const double k = (double)ks[i];
            const double n = j < 2000 ? 0.0002 * j : 0.001 * (j - 2000);
            const double f = curve(n);
            TEST_ASSERT_TRUE(shows(&seen, TRIBO_RELAY_Q) || n == 0.0);
            const double L = newton(seen.L);
            TEST_ASSERT_DOUBLE_WITHIN(1e-6 * L, fmin(L, k * L * tanh(n / (k * L))), f);
        }
    }
}

static void test_friction_breakaway_ends_at_full_scale(void)
{
    config.positive = (tribo_breakaway_f32_t){.offset_n = 1.0f, .slope = 1.0f};
    init();
    const double forces[] = {0.999, 1.0, 1.5, 1.999};
    for (size_t i = 0; i < sizeof forces / sizeof forces[0]; i++)
    {
        const double f = step(1.99999, forces[i]);
        TEST_ASSERT_DOUBLE_WITHIN(4e-9, fmin(2.0, 1.0 + forces[i]), newton(seen.L));
        TEST_ASSERT_DOUBLE_WITHIN(4e-9, 1.99999 - forces[i], f);
    }
}

#include "runners/test_friction_q31.inc" // main
