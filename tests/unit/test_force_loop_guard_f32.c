// What only the f32 arithmetic has. What both promise: tests/contract/test_loop_guard.c.

#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_f32.h"

#include "unity.h"

#include <math.h>

static tribo_force_loop_f32_params_t  params;
static tribo_force_loop_f32_state_t   loop;
static tribo_guard_f32_params_t       guard_params;
static tribo_force_loop_f32_signals_t signals;

void setUp(void)
{
    const tribo_force_loop_f32_config_t config   = tribo_force_loop_f32_paper();
    const tribo_guard_f32_config_t      standard = tribo_guard_f32_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&params, &config));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_guard_f32_init(&guard_params, &standard, 1.0e-3f));
    params.guard = &guard_params;
    loop.memory  = NULL;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_start(&loop, &params, false));
}

static void tick(double r, double y)
{
    (void)tribo_force_loop_f32_step(&params, &loop, (float)(r), (float)(y), &signals);
}

static void test_a_corrupt_friction_is_not_judged(void)
{
    loop.friction_n = NAN; // of a loop whose state is corrupt
    tick(0.5, 0.5);
    TEST_ASSERT_FALSE(loop.guard.running);
    tick(0.5, 0.5);
    TEST_ASSERT_TRUE(loop.guard.running);
}

/// A tick of a loop with the feed-forward, whose memory is corrupt. Returns the term of the tick before.
static float tick_corrupt(float r, float y)
{
    static tribo_feedforward_f32_params_t feedforward;
    static tribo_feedforward_f32_memory_t memory;
    tribo_force_loop_f32_config_t         config = tribo_force_loop_f32_paper();
    const tribo_feedforward_f32_config_t  method = tribo_feedforward_f32_default();
    const tribo_guard_f32_config_t        limits = tribo_guard_f32_default();

    config.method = tribo_feedforward_f32_use(&feedforward, &method);
    config.guard  = tribo_guard_f32_use(&guard_params, &limits);
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&params, &config));
    loop.memory = &memory.state.tick;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_start(&loop, &params, false));
    for (int k = 0; k < 100; k++)
    {
        tick(0.4 + 1e-4 * k, 0.4);
    }
    memory.state.rate = 1e30f;
    const float term  = signals.friction_term_n;
    (void)tribo_force_loop_f32_step(&params, &loop, r, y, &signals);
    TEST_ASSERT_EQUAL_UINT8(TRIBO_FEEDFORWARD_ENTER, memory.state.mode);
    return term;
}

static void test_a_corrupt_memory_leaves_the_controller_alone_and_the_guard_no_friction(void)
{
    const float term = tick_corrupt(0.5f, 0.25f);
    TEST_ASSERT_EQUAL_FLOAT(0.25f, signals.e_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, term, signals.friction_term_n);      // u goes on
    TEST_ASSERT_TRUE(loop.guard.play.position_n <= guard_params.half_n); // as it judged 0
}

static void test_a_corrupt_memory_beside_a_bad_reading_gives_no_error(void)
{
    (void)tick_corrupt(0.5f, NAN);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, signals.e_n);
    (void)tick_corrupt(NAN, 0.25f);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, signals.e_n);
}

#include "runners/test_force_loop_guard_f32.inc" // main
