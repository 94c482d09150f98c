#include ARITH_HEADER
#include "plain_relays.h"
#include "random.h"
#include "runs.h"
#include "unity.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#define H 1e-3

static tribo_friction_f32_config_t config;
static friction_t                  friction;

void setUp(void)
{
    config = tribo_force_loop_f32_paper().compensator.friction;
}

static friction_seen_t after(uint8_t armed, double n_before, double n)
{
    friction_start(&friction, armed, n_before);
    return friction_step(&friction, n, 0.0);
}

#define FORCE_TOLERANCE_N 1e-8                     // of a sum of few terms
#define TABLE_TOLERANCE_N TRIBO_EITHER(1e-7, 1e-8) // between points
#define CURVE_TOLERANCE_N TRIBO_EITHER(3e-7, 5e-8) // of f at 0.1 N

static void init(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, friction_init(&friction, &config, H));
}

/// Q2 armed: deep on the negative side, then back.
static void arm_q2(double F, double breakaway)
{
    for (int k = 0; k < 10; k++)
    {
        (void)friction_step(&friction, F - (k < 5 ? 0.9 : 0.1) * breakaway, F);
    }
}

static void test_friction_holds_against_the_net_force_up_to_breakaway(void)
{
    init();
    TEST_ASSERT_TRUE(friction_step(&friction, 0.5625, 0.5).f == 0.0625);
    const friction_seen_t held = friction_step(&friction, 0.75, 0.5);
    TEST_ASSERT_DOUBLE_WITHIN(FORCE_TOLERANCE_N, 0.157, held.L); // 0.007 + 0.3 * 0.5
    TEST_ASSERT_TRUE(held.f == held.L);
    TEST_ASSERT_DOUBLE_WITHIN(FORCE_TOLERANCE_N, -0.157, friction_step(&friction, 0.25, 0.5).f);
    TEST_ASSERT_DOUBLE_WITHIN(FORCE_TOLERANCE_N, -0.157, friction_step(&friction, -1.0, -0.5).f); // L grows with |F|
    TEST_ASSERT_TRUE(friction_step(&friction, 0.5, 0.5).f == 0.0);
}

static void test_friction_follows_k_of_v_through_its_whole_range(void)
{
    init();
    int rising = 0;
    for (int i = 0; i <= 4000; i++)
    {
        const double v = 0.0001 * pow(10.0, i / 1000.0); // 1e-4 to 1 N/s
        friction_reset(&friction);
        arm_q2(0.5, 0.157);
        const double          before = friction_step(&friction, 0.6, 0.5).n;
        const friction_seen_t now    = friction_step(&friction, 0.6 + v * H, 0.5);
        const double          rate   = (now.n - before) / H; // of what the arithmetic left of v
        TEST_ASSERT_EQUAL_INT(rate > 0.0, now.q);
        if (now.q)
        {
            const double k = 13.0 - 7.0 * tanh(3.0 * (rate / 0.007 - 1.0));
            TEST_ASSERT_DOUBLE_WITHIN(CURVE_TOLERANCE_N, k * now.L * tanh(now.n / (k * now.L)), now.f);
            rising++;
        }
    }
    TEST_ASSERT_TRUE(rising > 3900);
}

static void test_friction_needs_a_rising_magnitude_and_the_right_relay_for_its_hysteresis(void)
{
    init();
    arm_q2(0.5, 0.157);
    friction_seen_t now = friction_step(&friction, 0.45, 0.5); // n < 0 and Q1 low
    TEST_ASSERT_TRUE(now.q2 && !now.q1 && !now.q);
    TEST_ASSERT_TRUE(now.f == now.n);
    now = friction_step(&friction, 0.6, 0.5);
    TEST_ASSERT_TRUE(now.q);
    TEST_ASSERT_TRUE(now.f < 0.1 - 1e-5);
    now = friction_step(&friction, 0.6, 0.5); // v = 0
    TEST_ASSERT_FALSE(now.q);
    TEST_ASSERT_TRUE(now.f == now.n);
    now = friction_step(&friction, 0.5, 0.5); // n = 0
    TEST_ASSERT_FALSE(now.q);
    TEST_ASSERT_TRUE(now.f == 0.0);
}

static void test_friction_reports_net_force_and_its_rate_with_gravity(void)
{
    config.gravity_n = 0.01f;
    init();
    friction_seen_t now = friction_step(&friction, 0.5, 0.5);
    TEST_ASSERT_DOUBLE_WITHIN(TRIBO_EITHER(1e-9, 2e-9), 0.01, now.n);
    TEST_ASSERT_DOUBLE_WITHIN(TRIBO_EITHER(1e-5, 2e-6), 10.0, now.v);
    now = friction_step(&friction, 0.45, 0.5);
    TEST_ASSERT_DOUBLE_WITHIN(TRIBO_EITHER(1e-7, 4e-9), -0.04, now.n);
    TEST_ASSERT_DOUBLE_WITHIN(TRIBO_EITHER(1e-4, 4e-6), 30.0, now.v); // of |n|
}

/// Whether the relay that a large n on `side` arms is high after n was `first` L there, little for a while if `rests`, `then` L, and 0.
static bool armed_after(double side, double first, bool rests, double then)
{
    friction_reset(&friction);
    for (int k = 0; k < 10; k++)
    {
        (void)friction_step(&friction, 0.5 + side * (k < 5 || !rests ? first : 0.1 * first) * 0.157, 0.5);
    }
    (void)friction_step(&friction, 0.5 + side * then * 0.157, 0.5);
    const friction_seen_t now = friction_step(&friction, 0.5, 0.5);
    return side < 0.0 ? now.q2 : now.q1;
}

static void test_friction_arms_and_disarms_at_its_levels_only(void)
{
    init();
    for (double side = -1.0; side <= 1.0; side += 2.0)
    {
        TEST_ASSERT_FALSE(armed_after(side, 0.74, false, 0.0));
        TEST_ASSERT_TRUE(armed_after(side, 0.76, false, 0.0));
        TEST_ASSERT_TRUE(armed_after(side, 0.9, true, -0.79));
        TEST_ASSERT_FALSE(armed_after(side, 0.9, true, -0.81)); // n comes back from there in one step
    }
}

static void test_friction_levels_are_exclusive(void)
{
    config.positive    = (tribo_breakaway_f32_t){.offset_n = 0.5f, .slope = 0.0f};
    config.negative    = config.positive;
    config.reset_level = 0.5f;
    init();
    for (int sign = -1; sign <= 1; sign += 2)
    {
        friction_reset(&friction);
        for (int k = 0; k < 12; k++)
        {
            // At the set level for five ticks, 0, at the reset level on the other side for five ticks, 0.
            const double          n   = k < 5 ? 0.375 * sign : k == 5 || k == 11 ? 0.0 : -0.25 * sign;
            const friction_seen_t now = friction_step(&friction, n, 0.0);
            TEST_ASSERT_EQUAL_INT(k >= 5, sign < 0 ? now.q2 : now.q1);
        }
    }
}

static void test_friction_takes_each_direction_from_its_own_law(void)
{
    config.positive = (tribo_breakaway_f32_t){.offset_n = 0.01f, .slope = 0.25f};
    config.negative = (tribo_breakaway_f32_t){.offset_n = 0.02f, .slope = 0.5f};
    init();
    TEST_ASSERT_DOUBLE_WITHIN(FORCE_TOLERANCE_N, 0.11, friction_step(&friction, 1.9, 0.4).f);
    const friction_seen_t now = friction_step(&friction, -1.5, 0.4);
    TEST_ASSERT_DOUBLE_WITHIN(FORCE_TOLERANCE_N, -0.22, now.f);
    TEST_ASSERT_DOUBLE_WITHIN(FORCE_TOLERANCE_N, 0.22, now.L);
}

static void test_friction_table_is_linear_between_its_points_and_clamped_at_its_ends(void)
{
    static const tribo_breakaway_point_f32_t table[]       = {{0.1f, 0.01f, 0.02f},
                                                              {0.3f, 0.05f, 0.08f},
                                                              {0.4f, 0.04f, 0.2f}};
    static const double                      expected[][3] = {
        // |F|, L+, L-
        {0.0, 0.01, 0.02},
        {0.1, 0.01, 0.02},
        {0.15, 0.02, 0.035},
        {0.3, 0.05, 0.08},
        {0.375, 0.0425, 0.17},
        {0.4, 0.04, 0.2},
        {0.9, 0.04, 0.2},
    };
    config.table        = table;
    config.table_length = 3;
    init();
    for (size_t i = 0; i < sizeof expected / sizeof expected[0]; i++)
    {
        for (int sign = -1; sign <= 1; sign += 2)
        {
            const double F = sign * expected[i][0];
            TEST_ASSERT_DOUBLE_WITHIN(TABLE_TOLERANCE_N, expected[i][1], friction_step(&friction, F + 1.0, F).f);
            TEST_ASSERT_DOUBLE_WITHIN(TABLE_TOLERANCE_N, -expected[i][2], friction_step(&friction, F - 1.0, F).f);
        }
    }
    config.table_length = 1; // a constant
    init();
    TEST_ASSERT_DOUBLE_WITHIN(FORCE_TOLERANCE_N, 0.01, friction_step(&friction, 1.9, 0.0).f);
    TEST_ASSERT_DOUBLE_WITHIN(FORCE_TOLERANCE_N, -0.02, friction_step(&friction, -0.9, 0.7).f);
}

// L+ = 0.1 N, L- = 0.02 N, disarmed at 0.08 and 0.016.
static void test_friction_disarms_by_the_breakaway_of_the_side_where_n_was(void)
{
    static const tribo_breakaway_point_f32_t both[] = {{0.0f, 0.1f, 0.02f}, {1.0f, 0.1f, 0.02f}};
    config.positive                                 = (tribo_breakaway_f32_t){.offset_n = 0.1f, .slope = 0.0f};
    config.negative                                 = (tribo_breakaway_f32_t){.offset_n = 0.02f, .slope = 0.0f};
    for (int by_table = 0; by_table < 2; by_table++)
    {
        config.table        = by_table != 0 ? both : NULL;
        config.table_length = by_table != 0 ? 2 : 0;
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, friction_init(&friction, &config, H));
        TEST_ASSERT_TRUE(after(TRIBO_RELAY_Q2, 0.05, -0.01).q2); // within 0.08, though beyond 0.016
        TEST_ASSERT_FALSE(after(TRIBO_RELAY_Q2, 0.09, -0.01).q2);
        TEST_ASSERT_FALSE(after(TRIBO_RELAY_Q1, -0.018, 0.01).q1); // beyond 0.016, though within 0.08
        TEST_ASSERT_TRUE(after(TRIBO_RELAY_Q1, -0.015, 0.01).q1);
    }
}

// Numbers of few bits, so that levels are exact and met: L+ = 1/2 + |F|, L- = 1/4 + |F|/2; c1 = 3/4, c2 = 1/2.
static void check_relays(random_t *r)
{
    plain_relays_t plain    = plain_relays_at_rest();
    double         before   = 0.0;
    int            switches = 0;
    for (int k = 0; k < 20000; k++)
    {
        const double F       = (double)(random_bits(r) % 5u) / 8.0 * (random_bits(r) % 2u == 0u ? 1.0 : -1.0);
        const double level[] = {0.5 + fabs(F), 0.25 + fabs(F) / 2.0};
        const double n       = random_bits(r) % 4u == 0u ? before : (double)((int)(random_bits(r) % 49u) - 24) / 32.0;
        const bool   set1    = n < 0.75 * level[0];
        const bool   set2    = n > -0.75 * level[1];
        const bool   reset1  = n > before && before < -0.5 * level[1];
        const bool   reset2  = n < before && before > 0.5 * level[0];
        const bool   line[]  = {set1, set2, reset1, reset2};
        const bool   q1      = plain.output[0];
        plain_relays_step(&plain, friction_pulse_width(&friction), line);

        const friction_seen_t seen = friction_step(&friction, F + n, F);
        TEST_ASSERT_TRUE(n == seen.n);
        TEST_ASSERT_EQUAL_INT(plain.output[0], seen.q1);
        TEST_ASSERT_EQUAL_INT(plain.output[1], seen.q2);
        TEST_ASSERT_EQUAL_INT(fabs(n) > fabs(before) && (n > 0.0 ? seen.q2 : seen.q1), seen.q);
        switches += q1 != plain.output[0];
        before = n;
    }
    TEST_ASSERT_TRUE(switches > 200);
}

static void test_friction_relays_are_those_of_its_comparators(void)
{
    static const tribo_breakaway_point_f32_t points[] = {{0.0f, 0.5f, 0.25f},
                                                         {0.125f, 0.625f, 0.3125f},
                                                         {0.25f, 0.75f, 0.375f},
                                                         {0.375f, 0.875f, 0.4375f},
                                                         {0.5f, 1.0f, 0.5f}};
    random_t                                 r        = {1};
    config.positive                                   = (tribo_breakaway_f32_t){.offset_n = 0.5f, .slope = 1.0f};
    config.negative                                   = (tribo_breakaway_f32_t){.offset_n = 0.25f, .slope = 0.5f};
    config.reset_level                                = 0.5f;
    for (uint32_t width = 1; width <= 3u; width++)
    {
        config.pulse_width_s = (float)(width * H);
        for (int by_table = 0; by_table < 2; by_table++)
        {
            config.table        = by_table != 0 ? points : NULL;
            config.table_length = by_table != 0 ? 5 : 0;
            TEST_ASSERT_EQUAL_INT(TRIBO_OK, friction_init(&friction, &config, H));
            TEST_ASSERT_EQUAL_UINT32(width, friction_pulse_width(&friction));
            check_relays(&r);
        }
    }
}

/// The friction of `config` and of the same with a table: apart by `tolerance` at most, with the same relays.
static void check_table_for_law(const tribo_breakaway_point_f32_t *table, uint32_t length, double tolerance)
{
    static friction_t           by_table;
    tribo_friction_f32_config_t with_table = config;
    random_t                    r          = {4};
    int                         hysteresis = 0;
    with_table.table                       = table;
    with_table.table_length                = length;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, friction_init(&friction, &config, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, friction_init(&by_table, &with_table, H));
    for (int k = 0; k < RUNS(20000, 3000); k++)
    {
        const double          F    = 0.4 * sin(k * 0.001);
        const double          n    = 0.2 * sin(k * 0.013) + random_between(&r, -0.001, 0.001);
        const friction_seen_t law  = friction_step(&friction, F + n, F);
        const friction_seen_t seen = friction_step(&by_table, F + n, F);
        TEST_ASSERT_DOUBLE_WITHIN(tolerance, law.L, seen.L);
        TEST_ASSERT_DOUBLE_WITHIN(tolerance, law.f, seen.f);
        TEST_ASSERT_EQUAL_INT(law.q1, seen.q1);
        TEST_ASSERT_EQUAL_INT(law.q2, seen.q2);
        TEST_ASSERT_EQUAL_INT(law.q, seen.q);
        hysteresis += seen.q;
    }
    TEST_ASSERT_TRUE(hysteresis > RUNS(1000, 100));
}

static void test_friction_of_a_table_that_says_what_a_law_says_is_the_same(void)
{
    static const tribo_breakaway_point_f32_t constant[] = {{0.0f, 0.1f, 0.08f}, {1.0f, 0.1f, 0.08f}};
    static const tribo_breakaway_point_f32_t rising[]   = {{0.0f, 0.07f, 0.05f},
                                                           {0.3f, 0.145f, 0.2f},
                                                           {0.8f, 0.27f, 0.45f}};
    config.positive                                     = (tribo_breakaway_f32_t){.offset_n = 0.1f, .slope = 0.0f};
    config.negative                                     = (tribo_breakaway_f32_t){.offset_n = 0.08f, .slope = 0.0f};
    check_table_for_law(constant, 2, 0.0);
    check_table_for_law(constant, 1, 0.0);
    config.positive = (tribo_breakaway_f32_t){.offset_n = 0.07f, .slope = 0.25f};
    config.negative = (tribo_breakaway_f32_t){.offset_n = 0.05f, .slope = 0.5f};
    check_table_for_law(rising, 3, ROUNDING);
}

/// Rounds to a multiple of 2^-23 N, which is the same number in each arithmetic.
static double on_grid(double x)
{
    return round(x * 0x1p23) * 0x1p-23;
}

/// f at x = m (v/v0 - 1), with Q, near the saturation of L = 1 N, against Eqs. (3) and (5) in double. What k is off by counts as
/// far as f shows it: df/dk = L (tanh(s) - s/cosh(s)^2), s = n/(k L). Returns the part of `k_error` that f has used.
static double check_k(double x, double k_error)
{
    const double h     = (double)(float)H;
    const double range = (double)config.k_max - (double)config.k_min;
    const double k_mid = ((double)config.k_max + (double)config.k_min) / 2.0;
    const double v     = config.m > 0.0f ? (x / (double)config.m + 1.0) * (double)config.v0_n_per_s : 1.0;
    const double about = k_mid - range / 2.0 * tanh(x);
    const double n     = on_grid(about * atanh(0.98 / about));
    const double was   = n - on_grid(v * h);
    friction_start(&friction, TRIBO_RELAY_Q2, was);
    const friction_seen_t seen = friction_step(&friction, n, 0.0);
    if (!seen.q)
    {
        return 0.0; // v rounded to 0
    }
    const double rate  = (n - was) / h;
    const double k     = k_mid - range / 2.0 * tanh((double)config.m * (rate / (double)config.v0_n_per_s - 1.0));
    const double s     = n / k;
    const double slope = tanh(s) - s / pow(cosh(s), 2.0);
    const double exact = fmin(1.0, k * tanh(s));
    const double error = fmax(0.0, fabs(seen.f - exact) - FRICTION_CURVE_ERROR * exact);
    TEST_ASSERT_TRUE(error <= k_error * slope);
    return error / (k_error * slope);
}

// Over all k_max/k_min and m that are accepted: within 1e-6 and m/12 times that of k_max - k_min, and 2e-7 of k.
static void test_friction_k_of_v_is_as_close_as_arithmetic_allows(void)
{
    const float ms[]     = {0.0f, 0.3f, 1.0f, 3.0f, 10.0f, 20.0f, 50.0f, 100.0f};
    const float ratios[] = {1.0f, 1.01f, 1.1f, 1.5f, 2.0f, 3.33f, 20.0f, 900.0f};
    random_t    r        = {6};
    double      used     = 0.0;
    config.positive      = (tribo_breakaway_f32_t){.offset_n = 1.0f, .slope = 0.0f};
    config.v0_n_per_s    = 1.0f;
    for (int i = 0; i < 64; i++)
    {
        config.m     = ms[i % 8];
        config.k_min = 1.05f;
        config.k_max = config.k_min * ratios[i / 8];
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, friction_init(&friction, &config, H));
        const double range    = (double)config.k_max - (double)config.k_min;
        const double anywhere = (1.0 + (double)config.m / 12.0) * 1e-6 * range + 2e-7 * (double)config.k_max;
        // What friction_f32.h and friction_q31.h say, where it holds.
        const double said = config.m <= 20.0f && ratios[i / 8] >= 2.0f ? 2e-6 * range : anywhere;
        for (int j = 0; j < RUNS(400, 20); j++)
        {
            used = fmax(used, check_k(random_between(&r, -9.0, 9.0), fmin(said, anywhere)));
        }
    }
    TEST_ASSERT_TRUE(used > 0.2); // f shows an error of k
}

#include "runners/test_friction.inc" // main
