// What the compensator's signals mean with the feed-forward, and which presliding its formats hold.

#include ARITH_HEADER
#include "unity.h"

#include <math.h>

static loop_t                        loop;
static tribo_force_loop_f32_config_t config;

void setUp(void)
{
    const tribo_feedforward_f32_config_t own = tribo_feedforward_f32_default();
    config                                   = tribo_force_loop_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_feedforward(&loop, &config, &own));
}

void tearDown(void)
{
}

static double inner(double x)
{
    return TRIBO_LEARNED_N(double, x, FULL_SCALE_N);
}

static void test_feedforward_shows_expected_force_breakaway_and_friction(void)
{
    double y     = 0.0;
    double apart = 0.0;
    for (int k = 0; k < 2000; k++)
    {
        const double      r    = 0.1 + 1e-4 * (k < 1000 ? k : 2000 - k);
        const loop_seen_t seen = loop_step(&loop, r, y);
        y += 0.05 * (r - y);
        const TRIBO(feedforward, state_t) *state = &loop.memory.state;
        const double force    = inner((double)state->TRIBO_N(reached) + (double)state->TRIBO_N(behind)[0]);
        const double expected = inner((double)state->TRIBO_N(behind)[1] + (double)state->TRIBO_N(reached));
        apart                 = fmax(apart, fabs(force - expected));
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, force, seen.compensator.F);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, seen.u - force, seen.compensator.friction.n);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, loop_fed_friction(&loop), seen.compensator.friction.f);
        const double V0 = (double)state->learned.weight[0] / TRIBO_EITHER(1.0, 536870912.0);
        if (state->learning.stage != 5u) // its weights have just been learned
        {
            TEST_ASSERT_DOUBLE_WITHIN(1e-6, V0 * (0.007 + 0.3 * r), seen.compensator.friction.L);
        }
    }
    TEST_ASSERT_TRUE(apart > 1e-4); // force and expected reading are told apart
}

static void test_feedforward_takes_a_presliding_that_its_formats_hold(void)
{
    tribo_feedforward_f32_config_t own    = tribo_feedforward_f32_default();
    static const double            part[] = {1.04e-4, 0.96e-4, 0.249, 0.251}; // of the full scale
    for (int i = 0; i < 4; i++)
    {
        own.presliding_n  = (float)(part[i] * FULL_SCALE_N);
        const bool inside = i % 2 == 0 || !TRIBO_IS_Q31;
        TEST_ASSERT_EQUAL_INT(inside ? TRIBO_OK : TRIBO_ERR_PRESLIDING, loop_init_feedforward(&loop, &config, &own));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_feedforward_shows_expected_force_breakaway_and_friction);
    RUN_TEST(test_feedforward_takes_a_presliding_that_its_formats_hold);
    return UNITY_END();
}
