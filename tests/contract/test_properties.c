// What must hold whatever the inputs, over seeded random ones.

#include ARITH_HEADER
#include "random.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define SEED  0x7ab5u
#define TICKS 50000
#define H     1e-3

static random_t r;

void setUp(void)
{
    r.state = SEED;
}

/// A force that creeps, ramps, jumps and stands, within +-1 N.
typedef struct
{
    double at, slope;
    int    left; // ticks until it changes its mind
} wanderer_t;

static double wander(wanderer_t *w)
{
    if (w->left == 0)
    {
        const double kind = random_between(&r, 0.0, 1.0);
        w->left           = 1 + (int)random_between(&r, 0.0, 300.0);
        w->slope = kind < 0.2 ? 0.0 : random_between(&r, -1.0, 1.0) * pow(10.0, random_between(&r, -6.0, -2.0));
        w->at    = kind > 0.9 ? random_between(&r, -1.0, 1.0) : w->at;
    }
    w->left--;
    w->at = fmin(1.0, fmax(-1.0, w->at + w->slope));
    return w->at;
}

/// Rounds to a multiple of 2^-23 N, which is the same number in each arithmetic.
static double on_grid(double x)
{
    return round(x * 8388608.0) / 8388608.0;
}

static bool same(friction_seen_t a, friction_seen_t b)
{
    return a.n == b.n && a.L == b.L && a.v == b.v && a.f == b.f && a.q1 == b.q1 && a.q2 == b.q2 && a.q == b.q;
}

static void test_friction_of_symmetric_params_is_a_mirror_image(void)
{
    const tribo_friction_f32_config_t config = tribo_force_loop_f32_paper().compensator.friction;
    friction_t                        plain;
    friction_t                        mirror;
    wanderer_t                        u = {0.0, 0.0, 0};
    wanderer_t                        F = {0.0, 0.0, 0};
    int                               q = 0;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, friction_init(&plain, &config, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, friction_init(&mirror, &config, H));
    for (int k = 0; k < TICKS; k++)
    {
        const double          u_k = on_grid(wander(&u));
        const double          F_k = on_grid(u_k + 0.3 * wander(&F));
        const friction_seen_t a   = friction_step(&plain, u_k, F_k);
        const friction_seen_t b   = friction_step(&mirror, -u_k, -F_k);
        TEST_ASSERT_TRUE(a.f == -b.f);
        TEST_ASSERT_TRUE(a.q1 == b.q2 && a.q2 == b.q1 && a.q == b.q);
        q += a.q;
    }
    TEST_ASSERT_TRUE(q > TICKS / 100); // the hysteresis was there
}

static void test_friction_never_exceeds_breakaway_and_q_needs_a_rising_net_force(void)
{
    for (int set = 0; set < 20; set++)
    {
        tribo_friction_f32_config_t config = tribo_force_loop_f32_paper().compensator.friction;
        config.k_min                       = (float)random_between(&r, 1.02, 6.0);
        config.k_max                       = (float)random_between(&r, 6.0, 50.0);
        config.positive.offset_n           = (float)random_between(&r, 0.001, 0.05);
        config.negative.offset_n           = (float)random_between(&r, 0.001, 0.05);
        config.positive.slope              = (float)random_between(&r, 0.0, 0.5);
        config.negative.slope              = (float)random_between(&r, 0.0, 0.5);
        config.gravity_n                   = (float)random_between(&r, -0.01, 0.01);
        friction_t friction;
        wanderer_t u        = {0.0, 0.0, 0};
        wanderer_t F        = {0.0, 0.0, 0};
        double     n_before = 0.0;
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, friction_init(&friction, &config, H));
        for (int k = 0; k < TICKS / 10; k++)
        {
            const double          u_k = wander(&u);
            const double          F_k = u_k + 0.3 * wander(&F);
            const friction_seen_t s   = friction_step(&friction, u_k, F_k);
            const double L = s.n >= 0.0 ? (double)config.positive.offset_n + (double)config.positive.slope * fabs(F_k)
                                        : (double)config.negative.offset_n + (double)config.negative.slope * fabs(F_k);
            TEST_ASSERT_DOUBLE_WITHIN(4.0 * ROUNDING, L, s.L);
            TEST_ASSERT_TRUE(fabs(s.f) <= s.L);
            TEST_ASSERT_TRUE(!s.q || (s.v > 0.0 && fabs(s.n) > fabs(n_before)));
            TEST_ASSERT_TRUE(!s.q || (s.n > 0.0 ? s.q2 : s.q1));
            TEST_ASSERT_TRUE(s.f * s.n >= 0.0); // friction never drives
            TEST_ASSERT_TRUE(fabs(s.f) <= fabs(s.n));
            n_before = s.n;
        }
    }
}

static void test_friction_after_a_reset_runs_the_same_bit_for_bit(void)
{
    const tribo_friction_f32_config_t config = tribo_force_loop_f32_paper().compensator.friction;
    static friction_seen_t            first[5000];
    friction_t                        friction;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, friction_init(&friction, &config, H));
    for (int run = 0; run < 2; run++)
    {
        wanderer_t u = {0.0, 0.0, 0};
        r.state      = SEED;
        friction_reset(&friction);
        for (int k = 0; k < 5000; k++)
        {
            const double          u_k = wander(&u);
            const friction_seen_t s   = friction_step(&friction, u_k, 0.8 * u_k);
            TEST_ASSERT_TRUE(run == 0 || same(first[k], s));
            first[k] = s;
        }
    }
}

static bool same_loop(loop_seen_t a, loop_seen_t b)
{
    return a.e == b.e && a.v == b.v && a.u == b.u && a.limited == b.limited && a.compensator.F == b.compensator.F &&
           same(a.compensator.friction, b.compensator.friction);
}

static void test_loop_after_a_reset_runs_the_same_bit_for_bit(void)
{
    const tribo_force_loop_f32_config_t config = tribo_force_loop_f32_paper();
    static loop_seen_t                  first[5000];
    loop_t                              loop;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
    for (int run = 0; run < 2; run++)
    {
        wanderer_t reference = {0.0, 0.0, 0};
        r.state              = SEED;
        loop_reset(&loop);
        for (int k = 0; k < 5000; k++)
        {
            const double      r_k = wander(&reference);
            const loop_seen_t s   = loop_step(&loop, r_k, 0.99 * r_k);
            TEST_ASSERT_TRUE(run == 0 || same_loop(first[k], s));
            first[k] = s;
        }
    }
}

static void test_two_loops_do_not_touch_each_other(void)
{
    const tribo_force_loop_f32_config_t config = tribo_force_loop_f32_paper();
    static loop_seen_t                  alone[5000];
    loop_t                              one;
    loop_t                              two;
    for (int run = 0; run < 2; run++)
    {
        wanderer_t reference = {0.0, 0.0, 0};
        r.state              = SEED;
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&one, &config));
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&two, &config));
        for (int k = 0; k < 5000; k++)
        {
            const double      r_k = wander(&reference);
            const loop_seen_t s   = loop_step(&one, r_k, 0.99 * r_k);
            if (run == 1)
            {
                (void)loop_step(&two, -0.5 * r_k, 0.3);
                TEST_ASSERT_TRUE(same_loop(alone[k], s));
            }
            alone[k] = s;
        }
    }
}

static void test_loop_stays_within_its_limits_and_finite_over_wild_inputs(void)
{
    tribo_force_loop_f32_config_t config = tribo_force_loop_f32_paper();
    config.controller.u_min_n            = -0.4f;
    config.controller.u_max_n            = 0.7f;
    loop_t loop;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
    int limited = 0;
    for (int k = 0; k < TICKS; k++)
    {
        const double      r_k = random_between(&r, -3.0, 3.0); // beyond input_max_n too
        const double      y_k = k % 7 == 0 ? random_between(&r, -1e9, 1e9) : random_between(&r, -2.0, 2.0);
        const loop_seen_t s   = loop_step(&loop, r_k, y_k);
        TEST_ASSERT_TRUE(s.u >= -0.4 - ROUNDING && s.u <= 0.7 + ROUNDING);
        TEST_ASSERT_TRUE(isfinite(s.v) && isfinite(s.compensator.F) && isfinite(s.compensator.friction.f));
        limited += s.limited;
    }
    TEST_ASSERT_TRUE(limited > TICKS / 10);
    // And it has not been led astray: with r = y it comes to rest.
    double u = 0.0;
    for (int k = 0; k < 3000; k++)
    {
        const double before = u;
        u                   = loop_step(&loop, 0.1, 0.1).u;
        TEST_ASSERT_TRUE(k < 2000 || fabs(u - before) < 1e-5);
    }
}

#include "runners/test_properties.inc" // main
