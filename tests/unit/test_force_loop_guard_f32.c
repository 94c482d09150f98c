#include "tribo/force_loop_guard_f32.h"

#include "tribo/force_loop_feedforward_f32.h"
#include "tribo/force_loop_lugre_f32.h"
#include "unity.h"

#include <math.h>
#include <stddef.h>

static tribo_force_loop_f32_params_t  params;
static tribo_force_loop_f32_state_t   loop;
static tribo_feedforward_f32_params_t feedforward;
static tribo_feedforward_f32_memory_t memory;
static tribo_guard_f32_params_t       guard_params;
static tribo_guard_f32_state_t        guard;
static tribo_force_loop_f32_signals_t signals;

void setUp(void)
{
    const tribo_force_loop_f32_config_t config   = tribo_force_loop_f32_paper();
    const tribo_guard_f32_config_t      standard = tribo_guard_f32_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&params, &config));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_guard_f32_init(&guard_params, &standard, 1.0e-3f));
    tribo_force_loop_f32_reset(&loop);
    tribo_guard_f32_reset(&guard);
}

void tearDown(void)
{
}

static void feed_forward(void)
{
    const tribo_force_loop_f32_config_t  config = tribo_force_loop_f32_paper();
    const tribo_feedforward_f32_config_t method = tribo_feedforward_f32_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_feedforward_f32_init(&params, &feedforward, &config, &method));
    tribo_feedforward_f32_reset(&feedforward, &memory.state);
    tribo_force_loop_feedforward_f32_attach(&loop, &memory);
}

static void tick(double r, double y)
{
    (void)tribo_force_loop_f32_step(&params, &loop, (float)(r), (float)(y), &signals);
    tribo_force_loop_guard_f32_watch(&guard_params, &guard, &params, &loop, (float)(r), (float)(y), &signals);
}

static void test_a_latched_cause_fades_the_papers_friction(void)
{
    for (int k = 0; k < 2000; k++)
    {
        tick(0.5, 0.45);
    }
    TEST_ASSERT_TRUE(loop.friction_n != 0);
    TEST_ASSERT_TRUE(guard.share == 1.0f);
    guard.cause = TRIBO_GUARD_HUNTING;
    tick(0.5, 0.45);
    TEST_ASSERT_TRUE(guard.share < 1.0f && guard.share > 0);
    for (int k = 0; k < 600; k++)
    {
        tick(0.5, 0.45);
    }
    TEST_ASSERT_TRUE(loop.friction_n == 0 && signals.feedforward_n == 0);
}

static void test_a_latched_cause_fades_what_is_fed_forward(void)
{
    feed_forward();
    for (int k = 0; k < 1000; k++)
    {
        tick(0.3 + 1e-4 * k, 0.3 + 1e-4 * k);
    }
    TEST_ASSERT_TRUE(memory.signals.f_n > 0);
    guard.cause = TRIBO_GUARD_OVERSHOOT;
    for (int k = 1000; k < 1600; k++)
    {
        tick(0.3 + 1e-4 * k, 0.3 + 1e-4 * k);
    }
    TEST_ASSERT_TRUE(memory.state.share == 0);
    TEST_ASSERT_TRUE(memory.signals.f_n == 0);
    for (int k = 0; k < 3000; k++) // r stands: what is fed back fades, too
    {
        tick(0.46, k % 500 < 250 ? 0.4 : 0.5);
    }
    TEST_ASSERT_TRUE(memory.signals.f_n == 0);
}

static void test_bad_inputs_are_not_judged(void)
{
    tick(3.0, 0.5);
    tick(0.5, 3.0);
    signals.feedforward_n = NAN; // of a loop whose state is corrupt
    tribo_force_loop_guard_f32_watch(&guard_params, &guard, &params, &loop, 0.5f, 0.5f, &signals);
    TEST_ASSERT_FALSE(guard.running);
    tick(0.5, 0.5);
    TEST_ASSERT_TRUE(guard.running);
}

static void test_a_loop_whose_memory_is_not_attached_is_judged_by_what_it_adds(void)
{
    feed_forward();
    tribo_force_loop_feedforward_f32_attach(&loop, NULL);
    tick(0.5, 0.5);
    TEST_ASSERT_TRUE(guard.running && guard.share == 1.0f);
}

/// Half of what friction was is left; with all of it, u would jump by 60 mN in the tick after the change.
static void check_share_is_taken_over(const tribo_force_loop_f32_params_t *next)
{
    feed_forward();
    for (int k = 0; k < 2000; k++)
    {
        tick(0.3 + 1e-4 * k, 0.3 + 1e-4 * k);
        guard.cause = k == 1750 ? TRIBO_GUARD_HUNTING : guard.cause;
    }
    double u = (double)signals.controller.u_n;
    for (int k = 2000; k < 2003; k++)
    {
        const double r = 0.3 + 1e-4 * k;
        (void)tribo_force_loop_f32_step(next, &loop, (float)(r), (float)(r), &signals);
        tribo_force_loop_guard_f32_watch(&guard_params, &guard, next, &loop, (float)(r), (float)(r), &signals);
        TEST_ASSERT_DOUBLE_WITHIN(1.5e-3, u, (double)signals.controller.u_n);
        u = (double)signals.controller.u_n;
    }
}

static void test_the_papers_method_takes_over_the_share_that_a_guard_has_left(void)
{
    static tribo_force_loop_f32_params_t paper;
    const tribo_force_loop_f32_config_t  config = tribo_force_loop_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&paper, &config));
    check_share_is_taken_over(&paper);
}

static void test_so_does_lugre(void)
{
    static tribo_force_loop_f32_params_t next;
    static tribo_lugre_f32_params_t      lugre;
    const tribo_force_loop_f32_config_t  config   = tribo_force_loop_f32_paper();
    const tribo_lugre_f32_config_t       friction = tribo_lugre_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_lugre_f32_init(&next, &lugre, &config, &friction));
    check_share_is_taken_over(&next);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_latched_cause_fades_the_papers_friction);
    RUN_TEST(test_a_latched_cause_fades_what_is_fed_forward);
    RUN_TEST(test_bad_inputs_are_not_judged);
    RUN_TEST(test_a_loop_whose_memory_is_not_attached_is_judged_by_what_it_adds);
    RUN_TEST(test_the_papers_method_takes_over_the_share_that_a_guard_has_left);
    RUN_TEST(test_so_does_lugre);
    return UNITY_END();
}
