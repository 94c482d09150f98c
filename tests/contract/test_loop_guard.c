// A guard beside a loop: what it judges, and what its fade does to each method.

#define FULL_SCALE_N 4.0 // of Q31, so that an input beyond input_max shows as such
#include ARITH_HEADER
#include "unity.h"

#include <string.h>

static tribo_force_loop_f32_config_t config;
static loop_t                        loop;
static guard_t                       guard;

void setUp(void)
{
    config = tribo_force_loop_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, guard_init(&guard, 1e-3));
    loop_guard(&loop, &guard);
}

static void feed_forward(void)
{
    const tribo_feedforward_f32_config_t method = tribo_feedforward_f32_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_feedforward(&loop, &config, &method));
    loop_guard(&loop, &guard);
}

static void test_a_latched_cause_fades_the_papers_friction(void)
{
    loop_seen_t seen = {.u = 0.0};
    for (int k = 0; k < 2000; k++)
    {
        seen = loop_step(&loop, 0.5, 0.45);
    }
    TEST_ASSERT_TRUE(seen.feedforward != 0.0);
    TEST_ASSERT_TRUE(loop_share(&loop) == 1.0);
    loop.state.guard.cause = TRIBO_GUARD_HUNTING;
    (void)loop_step(&loop, 0.5, 0.45);
    TEST_ASSERT_TRUE(loop_share(&loop) < 1.0 && loop_share(&loop) > 0.0);
    for (int k = 0; k < 600; k++)
    {
        seen = loop_step(&loop, 0.5, 0.45);
    }
    TEST_ASSERT_TRUE(loop.state.guard.fade == 0 && seen.feedforward == 0.0);
}

static void test_a_loop_has_all_its_friction_when_no_guard_is_named(void)
{
    for (int k = 0; k < 1000; k++)
    {
        loop.state.guard.cause = TRIBO_GUARD_HUNTING;
        (void)loop_step(&loop, 0.5, 0.45);
    }
    TEST_ASSERT_TRUE(loop.state.guard.fade == 0);
    loop_detach_guard(&loop);
    (void)loop_step(&loop, 0.5, 0.45);
    TEST_ASSERT_TRUE(loop_step(&loop, 0.5, 0.45).feedforward > 0.0);
}

static void test_a_restart_keeps_a_latched_cause_and_its_fade_with_what_was_learned(void)
{
    for (int k = 0; k < 100; k++)
    {
        loop.state.guard.cause = TRIBO_GUARD_HUNTING;
        (void)loop_step(&loop, 0.5, 0.45);
    }
    const double share = loop_share(&loop);
    TEST_ASSERT_TRUE(share > 0.0 && share < 1.0);
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, TRIBO(force_loop, start)(&loop.state, &loop.params, true));
    TEST_ASSERT_TRUE(loop_share(&loop) == share && loop.state.guard.cause == TRIBO_GUARD_HUNTING);
    TEST_ASSERT_TRUE(loop.state.guard.running == 0u && loop.state.guard.since == 0u);
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, TRIBO(force_loop, start)(&loop.state, &loop.params, false));
    TEST_ASSERT_TRUE(loop_share(&loop) == 1.0 && loop.state.guard.cause == TRIBO_GUARD_NONE);
}

static void test_the_first_start_of_a_zeroed_state_has_nothing_to_keep(void)
{
    memset(&loop.state, 0, sizeof loop.state);
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, TRIBO(force_loop, start)(&loop.state, &loop.params, true));
    TEST_ASSERT_TRUE(loop_share(&loop) == 1.0);
}

/// Returns the jump of u when the params of a loop whose guard has faded friction to nothing become those of `to`.
static double jump_to(loop_t *to)
{
    static loop_t unchanged;
    static loop_t changed;
    for (int k = 0; k < 1000; k++)
    {
        loop.state.guard.cause = TRIBO_GUARD_HUNTING;
        (void)loop_step(&loop, 0.5, 0.45);
    }
    loop_copy(&unchanged, &loop);
    loop_copy(&changed, &loop);
    const double first = loop_step(&unchanged, 0.5, 0.45).u - loop_step_by(&changed, to, 0.5, 0.45).u;
    const double next  = loop_step(&unchanged, 0.5, 0.45).u - loop_step_by(&changed, to, 0.5, 0.45).u;
    return fmax(fabs(first), fabs(next));
}

static void test_u_does_not_jump_when_a_guard_is_given_up(void)
{
    static loop_t to;
    loop_copy(&to, &loop);
    to.params.guard = NULL;
    TEST_ASSERT_TRUE(jump_to(&to) < 1e-3);
}

static void test_u_does_not_jump_when_friction_that_a_guard_has_faded_changes(void)
{
    static loop_t to;
    config.compensator.friction.positive.slope = 0.1f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&to, &config));
    to.params.guard = &guard.params;
    TEST_ASSERT_TRUE(jump_to(&to) < 1e-3);
}

static void test_a_latched_cause_fades_out_the_feed_forward(void)
{
    feed_forward();
    for (int k = 0; k < 1000; k++)
    {
        (void)loop_step(&loop, 0.3 + 1e-4 * k, 0.3 + 1e-4 * k);
    }
    TEST_ASSERT_TRUE(loop_fed_friction(&loop) > 0.0);
    loop.state.guard.cause = TRIBO_GUARD_OVERSHOOT;
    for (int k = 1000; k < 1600; k++)
    {
        (void)loop_step(&loop, 0.3 + 1e-4 * k, 0.3 + 1e-4 * k);
    }
    TEST_ASSERT_TRUE(loop.state.guard.fade == 0);
    TEST_ASSERT_TRUE(loop_fed_friction(&loop) == 0.0);
    for (int k = 0; k < 3000; k++) // r stands: what is fed back fades, too
    {
        (void)loop_step(&loop, 0.46, k % 500 < 250 ? 0.4 : 0.5);
    }
    TEST_ASSERT_TRUE(loop_fed_friction(&loop) == 0.0);
}

static void test_bad_inputs_are_not_judged(void)
{
    (void)loop_step(&loop, 3.0, 0.5);
    (void)loop_step(&loop, 0.5, 3.0);
    TEST_ASSERT_FALSE(loop.state.guard.running);
    (void)loop_step(&loop, 0.5, 0.5);
    TEST_ASSERT_TRUE(loop.state.guard.running);
}

static void test_a_loop_whose_memory_is_not_named_is_judged_by_what_it_adds(void)
{
    feed_forward();
    loop_detach_memory(&loop);
    (void)loop_step(&loop, 0.5, 0.5);
    TEST_ASSERT_TRUE(loop.state.guard.running && loop_share(&loop) == 1.0);
}

/// Half of what friction was is left; with all of it, u would jump by 60 mN in the tick after the change.
static void check_fade_is_taken_over(loop_t *next)
{
    feed_forward();
    next->params.guard = &guard.params;
    double u           = 0.0;
    for (int k = 0; k < 2000; k++)
    {
        u                      = loop_step(&loop, 0.3 + 1e-4 * k, 0.3 + 1e-4 * k).u;
        loop.state.guard.cause = k == 1750 ? TRIBO_GUARD_HUNTING : loop.state.guard.cause;
    }
    for (int k = 2000; k < 2003; k++)
    {
        const double r = 0.3 + 1e-4 * k;
        const double v = loop_step_by(&loop, next, r, r).u;
        TEST_ASSERT_DOUBLE_WITHIN(1.5e-3, u, v);
        u = v;
    }
}

static void test_the_papers_method_takes_over_the_fade_that_a_guard_has_left(void)
{
    static loop_t paper;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&paper, &config));
    check_fade_is_taken_over(&paper);
}

#include "runners/test_loop_guard.inc" // main
